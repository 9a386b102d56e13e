// Quantisation lets vertices fall together. Where whole edges do, a reader who welds equal points would find
// a non-manifold edge that the input did not have.
#pragma once

#include <vector>

#include "codec/coded/weights.hpp"

namespace colossus::codec::quantization {

// Moves vertices on no face by a few units of weight where edges fall together. `triangles` are those that
// are left after merging. Vertices on faces stay, or neighbours would disagree. Linear.
void separate_edges(const std::vector<mesh::Triangle>& triangles, std::vector<coded::Weights>& weights);

// Gives edges that still fall together, since their ends lie on faces or have been merged, a vertex of their
// own in the middle. `is_merged`: vertices that stand for several which fell together within triangles;
// elsewhere an edge of several pairs of triangles is the input's own.
void split_edges(std::vector<mesh::Vertex>& vertices, std::vector<mesh::Triangle>& triangles,
                 std::vector<coded::Weights>& weights, const std::vector<bool>& is_merged);

}  // namespace colossus::codec::quantization
