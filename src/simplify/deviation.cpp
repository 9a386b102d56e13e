#include "simplify/deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/vector.hpp"
#include "mesh/adjacency.hpp"

namespace colossus::simplify {
namespace {

using geometry::Vec3;

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr double kFar = std::numeric_limits<double>::infinity();

// Squared distance from p to the triangles around v; `best` if none is nearer.
double squared_distance_around(const Vec3& p, const mesh::Mesh& mesh, const mesh::Adjacency& adjacency, std::uint32_t v,
                               double best) {
  for (const auto i : adjacency.around(v)) {
    const mesh::Triangle& t = mesh.triangles[i];
    best = std::min(best, geometry::squared_distance_to_triangle(p, geometry::to_vec3(mesh.vertices[t[0]].position),
                                                                 geometry::to_vec3(mesh.vertices[t[1]].position),
                                                                 geometry::to_vec3(mesh.vertices[t[2]].position)));
  }
  return best;
}

float rounded_up(double value) {
  const float rounded = static_cast<float>(value);
  return static_cast<double>(rounded) < value ? std::nextafter(rounded, std::numeric_limits<float>::infinity()) : rounded;
}

}  // namespace

std::vector<float> accumulate_deviations(const mesh::Mesh& before, std::span<const float> before_deviations,
                                         const mesh::Mesh& after, std::span<const std::uint32_t> representative) {
  mesh::Adjacency around_before;
  mesh::Adjacency around_after;
  around_before.build(before.triangles, before.vertices.size());
  around_after.build(after.triangles, after.vertices.size());
  std::vector<double> deviations(after.vertices.size(), 0.0);
  const auto raise = [&](std::uint32_t v, double value) { deviations[v] = std::max(deviations[v], value); };
  const auto has_stayed = [&](std::uint32_t v) {
    return representative[v] != kNone && before.vertices[v].position == after.vertices[representative[v]].position;
  };

  // Vertices of the finer mesh against the coarser, and placed vertices of the coarser against the finer.
  std::vector<double> placed(after.vertices.size(), kFar);
  for (std::uint32_t v = 0; v < before.vertices.size(); ++v) {
    const std::uint32_t r = representative[v];
    if (r == kNone) continue;
    if (has_stayed(v)) {
      raise(r, before_deviations[v]);
      placed[r] = 0.0;
      continue;
    }
    const Vec3 p = geometry::to_vec3(before.vertices[v].position);
    raise(r, before_deviations[v] + std::sqrt(squared_distance_around(p, after, around_after, r, kFar)));
    if (placed[r] > 0.0)
      placed[r] = squared_distance_around(geometry::to_vec3(after.vertices[r].position), before, around_before, v, placed[r]);
  }
  for (std::uint32_t v = 0; v < before.vertices.size(); ++v) {
    const std::uint32_t r = representative[v];
    if (r != kNone && placed[r] > 0.0) raise(r, before_deviations[v] + std::sqrt(placed[r]));
  }

  // Midpoints of edges of the finer mesh that lost an end; where both ends fell together, the vertices have said it.
  for (const mesh::Triangle& t : before.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k];
      const std::uint32_t b = t[(k + 1) % 3];
      const std::uint32_t ra = representative[a];
      const std::uint32_t rb = representative[b];
      if (a > b || ra == rb || ra == kNone || rb == kNone || (has_stayed(a) && has_stayed(b))) continue;
      const Vec3 middle = 0.5 * (geometry::to_vec3(before.vertices[a].position) + geometry::to_vec3(before.vertices[b].position));
      double squared = squared_distance_around(middle, after, around_after, ra, kFar);
      squared = squared_distance_around(middle, after, around_after, rb, squared);
      const double value = 0.5 * (before_deviations[a] + before_deviations[b]) + std::sqrt(squared);
      raise(ra, value);
      raise(rb, value);
    }
  std::vector<float> result(deviations.size());
  std::transform(deviations.begin(), deviations.end(), result.begin(), rounded_up);
  return result;
}

}  // namespace colossus::simplify
