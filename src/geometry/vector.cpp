#include "geometry/vector.hpp"

#include <algorithm>

namespace colossus::geometry {
namespace {

double squared_distance_to_segment(const Vec3& ap, const Vec3& ab) {
  const double along = dot(ap, ab);
  const double whole = dot(ab, ab);
  if (along <= 0.0) return squared_length(ap);
  if (along >= whole) return squared_length(ap - ab);
  const double squared = squared_length(ap) - along * along / whole;
  return squared > 0.0 ? squared : 0.0;
}

}  // namespace

TriangleDistance distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c,
                                      double bound) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const Vec3 n = cross(ab, ac);
  const double area = squared_length(n);
  const double height = dot(ap, n);
  // The plane is already farther.
  if (height * height >= bound * area && area > 0.0) return {bound, false};
  // Barycentric coordinates of the projection tell which edges it lies beyond.
  const double beyond_ac = dot(cross(ab, ap), n);  // weight of c
  const double beyond_ab = dot(cross(ap, ac), n);  // weight of b
  if (area > 0.0 && beyond_ab >= 0.0 && beyond_ac >= 0.0 && beyond_ab + beyond_ac <= area)
    return {height * height / area, true};
  double best = bound;
  if (!(area > 0.0) || beyond_ac < 0.0) best = std::min(best, squared_distance_to_segment(ap, ab));
  if (!(area > 0.0) || beyond_ab < 0.0) best = std::min(best, squared_distance_to_segment(ap, ac));
  if (!(area > 0.0) || beyond_ab + beyond_ac > area)
    best = std::min(best, squared_distance_to_segment(p - b, c - b));
  return {best, false};
}

}  // namespace colossus::geometry
