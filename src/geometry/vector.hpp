// Three doubles, scalar arithmetic in a fixed order: bytes of the container depend on it.
#pragma once

#include <cmath>

#include "geometry/point.hpp"

namespace colossus::geometry {

struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double squared_length(const Vec3& a) { return dot(a, a); }
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }

// Exact: lattice coordinates and their differences fit a double.
inline Vec3 to_vec3(const Point& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

struct TriangleDistance {
  double squared = 0.0;
  bool is_inside = false;  // the nearest point is the projection, within the triangle
};

// Squared distance from p to the closed triangle a b c, which may be degenerate, or `bound` if that is less:
// a small bound saves most of the work. Rounding can lose distances below 1e-7 of the triangle's size.
TriangleDistance distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c,
                                      double bound);

}  // namespace colossus::geometry
