// Checks everything about a container of diamonds that can be checked without its input, and with it the
// stored errors.
#pragma once

#include "reader/statue.hpp"
#include "reader/verify_report.hpp"

namespace colossus::reader {

// What is expected of the cuts: metadata counts named "border_edges" and "nonmanifold_edges" are the input's;
// where the container has none, the finest cut is what coarser ones are compared with. If the input has none,
// no cut may have any; else they are reported only.
//
// Distances: of samples_per_node deterministic samples of each node to the input; a relative 1e-9 and the
// last place of the coordinates are allowed for the arithmetic. Whether an error is loose is judged by the
// larger of these and the distances of the input's vertices in the node's tetrahedra to the node (an error
// also tells what simplification cut off), of the node and those below (their errors never exceed it). Nodes
// whose error is at most the lattice's own rounding, or four units of weight, do not count as loose.
//
// Never throws for damage in nodes (that is a finding); throws Error(kIo) when the device fails. Decodes each
// node once, on all usable processors; the report does not depend on their number. Memory: some 60 bytes per
// face of each tetrahedron, 32 per edge within faces of one level and of the leaves above it, and a batch of
// nodes.
VerifyReport verify(const Statue& statue, const VerifyOptions& options = {});

}  // namespace colossus::reader
