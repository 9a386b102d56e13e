// What collapses leave of a region: dead triangles and vertices are dropped.
#pragma once

#include <cstdint>
#include <vector>

#include "simplify/region.hpp"

namespace colossus::simplify {

// In the place of a triangle that a collapse has made degenerate.
inline constexpr mesh::Triangle kDeadTriangle{~std::uint32_t{0}, ~std::uint32_t{0}, ~std::uint32_t{0}};
inline bool is_dead(const mesh::Triangle& t) { return t[0] == kDeadTriangle[0]; }

// Drops the dead triangles and their cells; the others keep their order. Linear.
void drop_dead_triangles(Region& region);

// Given what each vertex has become (itself, or through others one that has stayed itself), drops vertices
// and renumbers the triangles: with `may_place` those that no triangle uses, else those that have become
// others. The rest keep their order. Returns the new number of what each vertex before has become. No
// triangle may be dead. Linear.
std::vector<std::uint32_t> drop_dead_vertices(Region& region, std::vector<std::uint32_t> representative);

}  // namespace colossus::simplify
