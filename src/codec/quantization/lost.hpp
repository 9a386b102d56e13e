// Triangles that quantisation lets collapse, and what keeps their surface from being lost with them.
//
// A triangle whose corners fall together leaves a segment, or a point. Where the surface goes on, another
// triangle of the tetrahedron has that segment for an edge. But of a wire thinner than a unit of weight, or
// of a crumb, nothing would be left, as far as it may be from the rest. There two triangles stay, back to
// back: closed, on no face, so that no neighbour has to know. The same becomes of what is thinner than a unit
// and falls together with its back.
#pragma once

#include <vector>

#include "codec/coded/weights.hpp"

namespace colossus::codec::quantization {

// Takes out pairs of opposite triangles over the same vertices: they bound nothing, and would make their
// edges non-manifold. (Two triangles whose vertices only share places may still be moved apart.) A pair that
// is no wider than the longest edge of the tetrahedron over 2^bits, and whose own longest edge has other
// triangles that are in no pair, is a fin that was folded flat; it goes. One triangle of each other pair is
// appended to `to_revive`. Returns how wide the widest fin was, lattice units.
double take_out_pairs(const hierarchy::Tetrahedron& tetrahedron, int position_bits,
                      const std::vector<coded::Weights>& weights, std::vector<mesh::Triangle>& triangles,
                      std::vector<mesh::Triangle>& to_revive);

// Of the triangles with equal corners, those whose segment is no edge of any triangle that is left, one for
// each segment; a point is covered by any triangle, or segment, that has it for a corner.
std::vector<mesh::Triangle> uncovered(const std::vector<mesh::Triangle>& lost,
                                      const std::vector<std::uint32_t>& welded,
                                      const std::vector<mesh::Triangle>& triangles);

// Adds two triangles back to back for each of these, with vertices of their own at places that nobody has,
// copies of the old ones. Returns of which vertex each new one is a copy, in their order.
std::vector<std::uint32_t> revive(const std::vector<mesh::Triangle>& to_revive,
                                  std::vector<mesh::Vertex>& vertices, std::vector<mesh::Triangle>& triangles,
                                  std::vector<coded::Weights>& weights);

}  // namespace colossus::codec::quantization
