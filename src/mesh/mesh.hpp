// Indexed triangle meshes on the lattice, with attributes; welding by position.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/bytes.hpp"
#include "geometry/octahedral.hpp"
#include "geometry/point.hpp"

namespace colossus::mesh {

using geometry::Normal16;
using geometry::Point;
using Color = std::array<std::uint8_t, 4>;  // red, green, blue, alpha
using Triangle = std::array<std::uint32_t, 3>;

// A position with attributes; scratch records hold arrays of these.
struct Vertex {
  Point position;
  Normal16 normal{0, 0, 32767};
  // Of the position as it was read, which the lattice may have moved onto another one; 0 once that does not
  // matter any more. See pipeline/facts/fingerprint.hpp.
  std::uint16_t fingerprint = 0;
  Color color{255, 255, 255, 255};
  friend bool operator==(const Vertex&, const Vertex&) = default;
};
static_assert(sizeof(Vertex) == 24);

struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
};

// Two equal lattice positions; collinear triangles with three distinct corners are not degenerate.
inline bool is_degenerate(const Point& a, const Point& b, const Point& c) {
  return a == b || b == c || c == a;
}

// Vertex indices of the first vertex at the same position, for each of the given positions. Linear; ordered
// by first occurrence, so it does not depend on any hash.
std::vector<std::uint32_t> position_remap(const std::vector<Vertex>& vertices);

// Merges vertices at equal positions (the first one's attributes stay), drops unused vertices, orders
// vertices by first use. Triangles that have become degenerate are dropped; `triangle_order`, if given,
// receives for each remaining triangle its former index.
void weld(Mesh& mesh, std::vector<std::uint32_t>* triangle_order = nullptr);

// Triangles with the same three corners: a representative of each is the first of its group. same_corners[i]
// is the index of the first triangle with the corners of triangle i, in whatever order. Linear but for large
// fans.
std::vector<std::uint32_t> first_with_same_corners(const std::vector<Triangle>& triangles,
                                                   std::size_t vertex_count);

// Whether two triangles with the same corners have them in the same cyclic order.
inline bool has_same_orientation(const Triangle& a, const Triangle& b) {
  return (a[0] == b[0] && a[1] == b[1]) || (a[0] == b[1] && a[1] == b[2]) || (a[0] == b[2] && a[1] == b[0]);
}

// The attributes at numerator / denominator of the way from a to b, in integers; the position is left to the
// caller.
Vertex interpolate(const Vertex& a, const Vertex& b, std::int64_t numerator, std::int64_t denominator);

// Halfway, position and all; coordinates rounded towards 0.
Vertex middle_of(const Vertex& a, const Vertex& b);

}  // namespace colossus::mesh
