// Quantisation lets vertices fall together. Where whole edges do, a reader who welds equal points would find a
// non-manifold edge that the input did not have.
#pragma once

#include <vector>

#include "codec/node_mesh.hpp"

namespace colossus::codec {

// Moves vertices on no face by one unit of weight where edges fall together. `triangles` are those that are left after
// merging. Vertices on faces stay: their place may depend on nothing but themselves, or neighbours would disagree. So a
// few pinches remain at low position bits, where a surface ends twice at one place of a face. Linear.
void separate_edges(const std::vector<mesh::Triangle>& triangles, std::vector<Weights>& weights);

}  // namespace colossus::codec
