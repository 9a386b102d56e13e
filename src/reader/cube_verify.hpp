// Checks everything about a container of blocks that can be checked without its input, and with it the stored
// errors.
#pragma once

#include "reader/cube_statue.hpp"
#include "reader/verify_report.hpp"

namespace colossus::reader {

// Bytes, rows, bounds; the conditions with sigma0, exactly; that the parent map of eight cubes makes their
// parent's triangles; that cubes agree about the vertices they share; border and non-manifold edges of every
// level, as an extracted level has them. As for diamonds, no level may have any where the input, or else the
// finest level, has none. Reported only: how dense triangles are along the borders of blocks.
//
// Distances: of samples_per_node deterministic samples of each node to the input. Whether an error is loose
// is judged by the larger of these and the distances of samples of the input to the level (each for the node
// that it is nearest to), of the node and those below.
//
// Never throws for damage in nodes (that is a finding); throws Error(kIo) when the device fails. Decodes each
// node twice, on all usable processors; the report does not depend on their number. Memory: some 100 bytes
// per vertex of one level that lies within reach of its cube's border, and a batch of nodes; with the input
// one whole level.
VerifyReport verify(const CubeStatue& statue, const VerifyOptions& options = {});

}  // namespace colossus::reader
