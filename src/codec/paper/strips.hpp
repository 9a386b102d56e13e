// Triangles as one strip of vertex indices, as graphics hardware draws it, and an order of triangles that
// makes it short and kind to a cache of vertices. After Hoppe, "Optimization of mesh locality for transparent
// vertex caching" (1999).
//
// Window k of a strip is the indices k, k + 1, k + 2. It is a triangle if they differ, with its first two
// corners exchanged where k is odd; else it is nothing, but joins strips or turns one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::codec::paper {

// Puts triangles into the order in which strips visit them, and turns their corners so that these strips need
// no joint within. Triangles that name a vertex twice come last. n log n.
void order_in_strips(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count);

// At most this many indices per triangle.
inline constexpr std::size_t kMaxStripIndices = 6;

// The strip of the first triangles, in this order and with this first corner each, up to the first triangle
// that names a vertex twice; of any others, but the more joints the less they are ordered. Linear.
struct Strip {
  std::vector<std::uint32_t> indices;
  std::size_t triangle_count = 0;
};
Strip strip_of(std::span<const mesh::Triangle> triangles);

// The other way round: writes the strip's triangles, and returns how many they are, or one more than fit.
// Linear.
std::size_t triangles_of_strip(std::span<const std::uint32_t> strip, std::span<mesh::Triangle> triangles);

}  // namespace colossus::codec::paper
