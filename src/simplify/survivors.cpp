#include "simplify/survivors.hpp"

namespace colossus::simplify {

void drop_dead_triangles(Region& region) {
  std::vector<mesh::Triangle>& triangles = region.mesh.triangles;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (!is_dead(triangles[i])) {
      triangles[kept] = triangles[i];
      region.cells[kept] = region.cells[i];
      ++kept;
    }
  triangles.resize(kept);
  region.cells.resize(kept);
}

std::vector<std::uint32_t> drop_dead_vertices(Region& region, std::vector<std::uint32_t> representative) {
  const std::size_t count = representative.size();
  std::vector<bool> is_kept(count, false);
  for (const mesh::Triangle& t : region.mesh.triangles)
    for (const auto v : t) is_kept[v] = true;
  if (!region.may_place)
    for (std::uint32_t v = 0; v < count; ++v) is_kept[v] = is_kept[v] || representative[v] == v;
  std::vector<std::uint32_t> renumbered(count, ~std::uint32_t{0});
  std::uint32_t kept = 0;
  for (std::uint32_t v = 0; v < count; ++v)
    if (is_kept[v]) {
      region.mesh.vertices[kept] = region.mesh.vertices[v];
      region.faces[kept] = region.faces[v];
      renumbered[v] = kept++;
    }
  region.mesh.vertices.resize(kept);
  region.faces.resize(kept);
  for (mesh::Triangle& t : region.mesh.triangles)
    for (auto& v : t) v = renumbered[v];
  std::vector<std::uint32_t> result(count);
  for (std::uint32_t v = 0; v < count; ++v) {
    std::uint32_t root = v;
    while (representative[root] != root) root = representative[root] = representative[representative[root]];
    result[v] = renumbered[root];
  }
  return result;
}

}  // namespace colossus::simplify
