#include "simplify/brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colossus::simplify {

using geometry::Vec3;

namespace {

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double squared = geometry::squared_length(along);
  const double t = squared > 0.0 ? std::clamp(geometry::dot(p - a, along) / squared, 0.0, 1.0) : 0.0;
  return geometry::length(a + t * along - p);
}

}  // namespace

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double rim =
      std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
  const Vec3 normal = geometry::cross(b - a, c - a);
  const double area = geometry::length(normal);
  if (!(area > 0.0)) return rim;
  const auto is_left = [&](const Vec3& from, const Vec3& to) {
    return geometry::dot(geometry::cross(to - from, p - from), normal) >= 0.0;
  };
  if (!is_left(a, b) || !is_left(b, c) || !is_left(c, a)) return rim;
  return std::min(rim, std::abs(geometry::dot(p - a, normal)) / area);
}

BruteForce::BruteForce(const mesh::Mesh& mesh) {
  const auto at = [&](std::uint32_t v) { return geometry::to_vec3(mesh.vertices[v].position); };
  for (const mesh::Triangle& t : mesh.triangles) {
    const std::array<Vec3, 3> corners{at(t[0]), at(t[1]), at(t[2])};
    const Vec3 middle = (1.0 / 3.0) * (corners[0] + corners[1] + corners[2]);
    double radius = 0.0;
    for (const Vec3& corner : corners) radius = std::max(radius, geometry::length(corner - middle));
    balls_.push_back({corners, middle, radius});
  }
}

double BruteForce::distance(const Vec3& p) const {
  double best = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls_) {
    const double reach = best + ball.radius;
    if (geometry::squared_length(p - ball.middle) > reach * reach) continue;
    best = std::min(best, distance_to_triangle(p, ball.corners[0], ball.corners[1], ball.corners[2]));
  }
  return best;
}

}  // namespace colossus::simplify
