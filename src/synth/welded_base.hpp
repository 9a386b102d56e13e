// The base mesh of synth as a welded mesh with numbered edges. Internal to src/synth.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "synth/synth.hpp"

namespace colossus::synth {

// In a namespace of their own: operators on arrays are for who asks for them.
namespace synth_points {

using Point = std::array<double, 3>;

inline Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Point operator*(const Point& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline double dot(const Point& a, const Point& b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace synth_points

// Vertices at equal positions made one, numbered by first use in a triangle; triangles with two equal corners
// dropped; edges numbered by first use. `normals` are of unit length, but zero at border and non-manifold
// edges and where triangles cancel out. `colors` is empty or as long as `positions`.
struct WeldedBase {
  std::vector<std::array<double, 3>> positions, normals;
  std::vector<std::array<std::uint8_t, 3>> colors;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 2>> edges;           // lower end first
  std::vector<std::array<std::uint32_t, 3>> triangle_edges;  // edge i joins corners i and i + 1
};

// Throws core::Error, kBadData: no triangles, or degenerate ones only; 2^31 or more vertices or triangles; an
// index out of range; a coordinate that is not finite; colors for another number of vertices. Cost: sorts the
// vertices and the triangles' sides.
WeldedBase weld_base(const BaseMesh& base);

}  // namespace colossus::synth
