// How far a simplified mesh lies from the one it was made of, and so, added up, from the input.
#pragma once

#include <span>
#include <vector>

#include "simplify/region.hpp"

namespace colossus::simplify {

// `before` is the mesh that was simplified to `after`; `representative[v]` is the vertex of `after` into which v of
// `before` has collapsed. Samples (vertices, and midpoints of edges that vanished) of either mesh are measured against
// the triangles of the other in the neighbourhood that the collapses connect; each adds the deviation that it had
// before. Any triangle there gives an upper bound of the distance, so the estimate errs upwards. Returns the
// deviations of after's vertices, each at least its own share of `before_deviations`. Linear.
std::vector<float> accumulate_deviations(const mesh::Mesh& before, std::span<const float> before_deviations,
                                         const mesh::Mesh& after, std::span<const std::uint32_t> representative);

}  // namespace colossus::simplify
