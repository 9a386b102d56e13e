// Separate pieces of a surface, which no collapse can take away: a closed one keeps four triangles for ever,
// and a cloud of crumbs would be as large at the root as in the input.
#pragma once

#include <cstdint>
#include <vector>

#include "simplify/region.hpp"

namespace colossus::simplify {

// Drops components of the region, small ones first, while it has more than `target` triangles. A component
// may go that touches no face, and whose every point lies within `limit` of one triangle that stays: its
// farthest corner does, counting how far those of the input's samples that are carried along are from it. So
// one always stays. Distances in lattice units.
//
// With a finite reach, corners become one vertex that is within reach of all that they stand for: `before`
// and `representative` are the vertices before the simplification, and what each has become. Vertices that
// are not used any more are dropped as by drop_dead_vertices(), `representative` is brought up to date,
// samples are attached to what stays. Returns how far a dropped one was at most, at most `limit`.
// Deterministic, whatever the order of triangles and vertices. Linear for a region of one component; else
// each component that may go is compared with the boxes of chunks of triangles, as long as that takes no more
// than some seconds.
double drop_components(Region& region, std::size_t target, double limit,
                       const std::vector<mesh::Vertex>& before, std::vector<std::uint32_t>& representative);

}  // namespace colossus::simplify
