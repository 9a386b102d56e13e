// Checks everything about a container of blocks that can be checked without its input, and with it how far
// each level and the input are from each other.
#pragma once

#include "reader/blocks/statue.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify::blocks {

// Bytes, rows, bounds; the conditions with sigma0, exactly; that the parent map of eight cubes makes their
// parent's triangles; that cubes agree about the vertices they share; border and non-manifold edges of every
// level, as an extracted level has them. As for diamonds, no level may have any where the input, or else the
// finest level, has none. Reported only: how dense triangles are along the borders of blocks.
//
// The finest level as a whole, inconsistently oriented edges (within cubes), the layout of the file, damage,
// and the input are compared as for diamonds (verify.hpp); border and non-manifold edges of the finest level
// are those of all its cubes together. From the input to each level samples_per_node per cube are measured,
// or as many as the level has triangles.
//
// Never throws for damage in nodes (that is a finding); throws Error(kIo) when the device fails. Decodes each
// node twice, on all usable processors; the report does not depend on their number. Memory: some 100 bytes
// per vertex of one level that lies within reach of its cube's border, and a batch of nodes; with the input
// also a copy of its points, one whole level, and an index over each.
measure::VerifyReport verify(const reader::blocks::Statue& statue,
                             const measure::VerifyOptions& options = {});

}  // namespace colossus::verify::blocks
