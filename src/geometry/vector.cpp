#include "geometry/vector.hpp"

#include <algorithm>

namespace colossus::geometry {
namespace {

double squared_distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double denominator = dot(ab, ab);
  const double t = denominator > 0.0 ? std::clamp(dot(p - a, ab) / denominator, 0.0, 1.0) : 0.0;
  return squared_length(p - (a + t * ab));
}

}  // namespace

double squared_distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 n = cross(ab, ac);
  const double area = squared_length(n);
  const Vec3 ap = p - a;
  if (area > 0.0) {
    // Barycentric coordinates of the projection decide whether it falls inside.
    const double v = dot(cross(ap, ac), n);
    const double w = dot(cross(ab, ap), n);
    if (v >= 0.0 && w >= 0.0 && v + w <= area) {
      const double height = dot(ap, n);
      return height * height / area;
    }
  }
  return std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                   squared_distance_to_segment(p, c, a)});
}

}  // namespace colossus::geometry
