#include "mesh/topology.hpp"

#include <algorithm>

namespace colossus::mesh {
namespace {

// A side of a triangle: its ends in order, and whether the triangle has them in that order too.
struct Side {
  std::uint64_t key;
  bool is_forward;
};

// Sorted by ends: dealt out by the lesser end, then sorted within these small groups.
std::vector<Side> sorted_sides(std::span<const Triangle> triangles) {
  std::uint32_t vertex_count = 0;
  for (const Triangle& t : triangles) vertex_count = std::max({vertex_count, t[0] + 1, t[1] + 1, t[2] + 1});
  std::vector<std::uint32_t> starts(std::size_t{vertex_count} + 1, 0);
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++starts[std::min(t[k], t[(k + 1) % 3]) + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) starts[v + 1] += starts[v];
  std::vector<Side> sides(triangles.size() * 3);
  std::vector<std::uint32_t> cursor(starts.begin(), starts.end() - 1);
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k];
      const std::uint64_t b = t[(k + 1) % 3];
      sides[cursor[std::min(a, b)]++] = {std::min(a, b) << 32 | std::max(a, b), a < b};
    }
  for (std::size_t v = 0; v < vertex_count; ++v)
    std::sort(sides.begin() + starts[v], sides.begin() + starts[v + 1],
              [](const Side& l, const Side& r) { return l.key < r.key; });
  return sides;
}

}  // namespace

std::vector<Edge> edges(std::span<const Triangle> triangles) {
  std::vector<Edge> result;
  for (const Side& side : sorted_sides(triangles)) {
    const auto a = static_cast<std::uint32_t>(side.key >> 32);
    const auto b = static_cast<std::uint32_t>(side.key);
    if (result.empty() || result.back().a != a || result.back().b != b) result.push_back({a, b, 0, 0});
    ++(side.is_forward ? result.back().forward : result.back().backward);
  }
  return result;
}

}  // namespace colossus::mesh
