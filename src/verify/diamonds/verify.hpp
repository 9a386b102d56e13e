// Checks everything about a container of diamonds that can be checked without its input, and with it how far
// each level and the input are from each other.
#pragma once

#include "reader/diamonds/statue.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify::diamonds {

// What is expected of the cuts: metadata counts named "border_edges" and "nonmanifold_edges" are the input's;
// where the container has none, the finest cut is what coarser ones are compared with. If the input has none,
// no cut may have any; else they are reported only. Non-manifold edges may be there as well where the
// container says that its finest level has some: the lattice lays thin plates onto each other.
//
// The finest level as a whole: triangles, area, border and non-manifold edges (those in no face of their
// tetrahedron) as the container says; its bounds those of the input to within the largest error of a leaf;
// its area at least half of the input's, and from 12 position bits on that to within 0.1 %, unless the build
// has found otherwise and stored it in the count "area_differs". Per level as many inconsistently oriented
// edges within tetrahedra as the container says. Where offsets hold, the node table before all chunks and
// these in the order of the rows. What an older container does not store is not checked, and the report says
// so.
//
// A node whose bytes are damaged is one finding: what its neighbours, the cuts that contain it and the errors
// of those above it would lack is not held against them.
//
// With the input: its numbers of vertices and triangles, its bounds (exactly), and its area without copies
// (to within what the lattice explains, or 0.1 %). Distances from the container to the input: of
// samples_per_node deterministic samples of each node. From the input to the cut of each level: of one sample
// per triangle of the input and half as many others at the finest level, of as many as the level has
// triangles at coarser ones; none may be farther than the largest error of the nodes that can stand for it
// (held_error.hpp). A relative 1e-9 and the last place of the coordinates are allowed for the arithmetic,
// which is done in units of the statue's size.
//
// Whether an error is loose is judged by the larger of these distances, of the node and those below (their
// errors never exceed it); a sixteenth of samples_per_node of the way from the input is measured exactly for
// that. Nodes whose error is at most the lattice's own rounding, or four units of weight, do not count as
// loose.
//
// Never throws for damage in nodes (that is a finding); throws Error(kIo) when the device fails. Decodes each
// node once, on all usable processors; the report does not depend on their number. Memory: some 60 bytes per
// face of each tetrahedron, 32 per edge within faces of one level and of the leaves above it, and a batch of
// nodes; with the input also a copy of its points, one whole level, and an index over each (some 20 bytes per
// triangle).
measure::VerifyReport verify(const reader::diamonds::Statue& statue,
                             const measure::VerifyOptions& options = {});

}  // namespace colossus::verify::diamonds
