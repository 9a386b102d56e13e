#include "mesh/topology.hpp"

#include <algorithm>
#include <numeric>

namespace colossus::mesh {
namespace {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0U);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  bool join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parents_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<std::uint32_t> parents_;
};

// A side of a triangle: ends in order, and the corner (3 * triangle + corner) that it starts at.
struct Side {
  std::uint64_t key;
  std::uint32_t corner;
  bool is_forward;
};

// Sorted by ends, then by corner: dealt out by the lesser end, then sorted within these small groups.
std::vector<Side> sorted_sides(std::span<const Triangle> triangles) {
  std::uint32_t vertex_count = 0;
  for (const Triangle& t : triangles) vertex_count = std::max({vertex_count, t[0] + 1, t[1] + 1, t[2] + 1});
  std::vector<std::uint32_t> starts(std::size_t{vertex_count} + 1, 0);
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++starts[std::min(t[k], t[(k + 1) % 3]) + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) starts[v + 1] += starts[v];
  std::vector<Side> sides(triangles.size() * 3);
  std::vector<std::uint32_t> cursor(starts.begin(), starts.end() - 1);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint64_t a = triangles[t][k];
      const std::uint64_t b = triangles[t][(k + 1) % 3];
      sides[cursor[std::min(a, b)]++] = {std::min(a, b) << 32 | std::max(a, b), 3 * t + k, a < b};
    }
  for (std::size_t v = 0; v < vertex_count; ++v)
    std::sort(sides.begin() + starts[v], sides.begin() + starts[v + 1], [](const Side& l, const Side& r) {
      return l.key != r.key ? l.key < r.key : l.corner < r.corner;
    });
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

std::vector<bool> nonmanifold_vertices(std::span<const Triangle> triangles, std::size_t vertex_count) {
  std::vector<bool> flags(vertex_count, false);
  // Corners at one vertex that share a manifold edge belong to one fan; more than one fan makes it
  // non-manifold.
  DisjointSets fans(triangles.size() * 3);
  const std::vector<Side> sides = sorted_sides(triangles);
  const auto corner_at = [&](std::uint32_t corner, std::uint32_t vertex) {
    const std::uint32_t t = corner / 3;
    for (std::uint32_t k = 0; k < 3; ++k)
      if (triangles[t][k] == vertex) return 3 * t + k;
    return corner;
  };
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i;
    while (end < sides.size() && sides[end].key == sides[i].key) ++end;
    const auto a = static_cast<std::uint32_t>(sides[i].key >> 32);
    const auto b = static_cast<std::uint32_t>(sides[i].key);
    if (end - i > 2) flags[a] = flags[b] = true;
    if (end - i == 2)
      for (const std::uint32_t vertex : {a, b})
        fans.join(corner_at(sides[i].corner, vertex), corner_at(sides[i + 1].corner, vertex));
    i = end;
  }
  std::vector<std::uint32_t> fan_of(vertex_count, ~std::uint32_t{0});
  for (std::uint32_t corner = 0; corner < triangles.size() * 3; ++corner) {
    const std::uint32_t vertex = triangles[corner / 3][corner % 3];
    const std::uint32_t fan = fans.find(corner);
    if (fan_of[vertex] == ~std::uint32_t{0}) fan_of[vertex] = fan;
    if (fan_of[vertex] != fan) flags[vertex] = true;
  }
  return flags;
}

std::size_t border_loop_count(std::span<const Edge> edges, std::size_t vertex_count) {
  DisjointSets chains(vertex_count);
  std::vector<bool> on_border(vertex_count, false);
  for (const Edge& edge : edges)
    if (edge.is_border()) {
      chains.join(edge.a, edge.b);
      on_border[edge.a] = on_border[edge.b] = true;
    }
  std::size_t loops = 0;
  for (std::uint32_t v = 0; v < vertex_count; ++v) loops += on_border[v] && chains.find(v) == v ? 1 : 0;
  return loops;
}

}  // namespace colossus::mesh
