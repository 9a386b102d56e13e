#include "simplify/vertex_class.hpp"

namespace colossus::simplify {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

enum class Fan { kClosed, kOpen, kIrregular };

// Walks around v from triangle to triangle. `next` and `is_end` are scratch arrays, all kNone and false
// between calls.
Fan fan_of(std::uint32_t v, const Region& region, const mesh::Adjacency& adjacency,
           std::vector<std::uint32_t>& next, std::vector<bool>& is_end) {
  const auto around = adjacency.around(v);
  const auto sides = [&](std::uint32_t i) {
    const mesh::Triangle& t = region.mesh.triangles[i];
    const std::size_t k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
    return std::array<std::uint32_t, 2>{t[(k + 1) % 3], t[(k + 2) % 3]};
  };
  bool is_regular = !around.empty();
  for (const auto i : around) {
    const auto [from, to] = sides(i);
    // Twice the same start or end: more than two triangles at an edge, or opposite orientations.
    if (next[from] != kNone || is_end[to]) is_regular = false;
    next[from] = to;
    is_end[to] = true;
  }
  std::uint32_t start = is_regular ? sides(around[0])[0] : kNone;
  bool is_open = false;
  for (const auto i : around) {
    const auto [from, to] = sides(i);
    if (!is_end[from]) {
      start = from;
      is_open = true;
    }
  }
  std::size_t steps = 0;
  // Once round, or to the open end; a second fan is not met.
  if (is_regular)
    for (std::uint32_t at = start; next[at] != kNone;) {
      ++steps;
      at = next[at];
      if (at == start) break;
    }
  for (const auto i : around) {
    const auto [from, to] = sides(i);
    next[from] = kNone;
    is_end[to] = false;
  }
  if (!is_regular || steps != around.size()) return Fan::kIrregular;
  return is_open ? Fan::kOpen : Fan::kClosed;
}

}  // namespace

std::vector<VertexClass> classify_vertices(const Region& region, const mesh::Adjacency& adjacency) {
  const std::size_t count = region.mesh.vertices.size();
  std::vector<VertexClass> classes(count, VertexClass::kLocked);
  std::vector<std::uint32_t> next(count, kNone);
  std::vector<bool> is_end(count, false);
  for (std::uint32_t v = 0; v < count; ++v) {
    if ((region.faces[v] & region.outer_faces) != 0) continue;
    switch (fan_of(v, region, adjacency, next, is_end)) {
      case Fan::kClosed:
        classes[v] = region.faces[v] == 0 ? VertexClass::kFree : VertexClass::kFace;
        break;
      case Fan::kOpen:
        classes[v] = VertexClass::kBorder;
        break;
      case Fan::kIrregular:
        break;
    }
  }
  return classes;
}

}  // namespace colossus::simplify
