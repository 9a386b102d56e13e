#include "mesh/mesh.hpp"

#include <algorithm>
#include <bit>

namespace colossus::mesh {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// a + (b - a) * t / d, rounded to nearest, halves up.
std::int64_t mix(std::int64_t a, std::int64_t b, std::int64_t t, std::int64_t d) {
  const std::int64_t scaled = 2 * ((a * (d - t)) + b * t) + d;
  std::int64_t quotient = scaled / (2 * d);
  if (scaled % (2 * d) < 0) --quotient;
  return quotient;
}

}  // namespace

std::vector<std::uint32_t> position_remap(const std::vector<Vertex>& vertices) {
  std::vector<std::uint32_t> remap(vertices.size());
  const std::size_t slots = std::bit_ceil(vertices.size() * 2 + 1);
  std::vector<std::uint32_t> table(slots, kNone);
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    std::size_t slot = geometry::PointHash{}(vertices[i].position) & (slots - 1);
    while (table[slot] != kNone && vertices[table[slot]].position != vertices[i].position)
      slot = (slot + 1) & (slots - 1);
    if (table[slot] == kNone) table[slot] = i;
    remap[i] = table[slot];
  }
  return remap;
}

void weld(Mesh& mesh, std::vector<std::uint32_t>* triangle_order) {
  const std::vector<std::uint32_t> remap = position_remap(mesh.vertices);
  std::vector<std::uint32_t> renumbered(mesh.vertices.size(), kNone);
  std::vector<Vertex> vertices;
  vertices.reserve(mesh.vertices.size());
  if (triangle_order != nullptr) triangle_order->clear();
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle triangle = mesh.triangles[t];
    for (auto& v : triangle) v = remap[v];
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    for (auto& v : triangle) {
      if (renumbered[v] == kNone) {
        renumbered[v] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(mesh.vertices[v]);
      }
      v = renumbered[v];
    }
    mesh.triangles[kept++] = triangle;
    if (triangle_order != nullptr) triangle_order->push_back(static_cast<std::uint32_t>(t));
  }
  mesh.triangles.resize(kept);
  mesh.vertices = std::move(vertices);
}

std::vector<std::uint32_t> first_with_same_corners(const std::vector<Triangle>& triangles,
                                                   std::size_t vertex_count) {
  // Dealt out by the least corner; then sorted by the two others within these groups.
  struct Entry {
    std::uint64_t others;
    std::uint32_t triangle;
  };
  std::vector<std::uint32_t> starts(vertex_count + 1, 0);
  for (const Triangle& t : triangles) ++starts[std::min({t[0], t[1], t[2]}) + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) starts[v + 1] += starts[v];
  std::vector<std::uint32_t> cursor(starts.begin(), starts.end() - 1);
  std::vector<Entry> entries(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const std::uint64_t least = std::min({t[0], t[1], t[2]});
    const std::uint64_t most = std::max({t[0], t[1], t[2]});
    const std::uint64_t middle = std::uint64_t{t[0]} + t[1] + t[2] - least - most;
    entries[cursor[least]++] = {middle << 32 | most, i};
  }
  std::vector<std::uint32_t> first(triangles.size());
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto begin = entries.begin() + starts[v];
    const auto end = entries.begin() + starts[v + 1];
    std::sort(begin, end, [](const Entry& a, const Entry& b) {
      return a.others != b.others ? a.others < b.others : a.triangle < b.triangle;
    });
    for (auto at = begin; at != end; ++at)
      first[at->triangle] =
          at != begin && (at - 1)->others == at->others ? first[(at - 1)->triangle] : at->triangle;
  }
  return first;
}

Vertex interpolate(const Vertex& a, const Vertex& b, std::int64_t numerator, std::int64_t denominator) {
  Vertex v;
  for (std::size_t i = 0; i < 3; ++i)
    v.normal[i] = static_cast<std::int16_t>(mix(a.normal[i], b.normal[i], numerator, denominator));
  for (std::size_t i = 0; i < 4; ++i)
    v.color[i] = static_cast<std::uint8_t>(mix(a.color[i], b.color[i], numerator, denominator));
  return v;
}

Vertex middle_of(const Vertex& a, const Vertex& b) {
  Vertex v = interpolate(a, b, 1, 2);
  for (int axis = 0; axis < 3; ++axis)
    v.position[axis] = static_cast<std::int32_t>((std::int64_t{a.position[axis]} + b.position[axis]) / 2);
  return v;
}

}  // namespace colossus::mesh
