#include "simplify/mesh_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace colossus::simplify {
namespace {

// The neighbours of each of some vertices.
using Graph = std::map<std::uint32_t, std::vector<std::uint32_t>>;

std::size_t component_count(const Graph& graph) {
  std::set<std::uint32_t> seen;
  std::size_t count = 0;
  for (const auto& [start, unused] : graph) {
    if (!seen.insert(start).second) continue;
    ++count;
    for (std::vector<std::uint32_t> open{start}; !open.empty();) {
      const std::uint32_t v = open.back();
      open.pop_back();
      for (const std::uint32_t neighbour : graph.at(v))
        if (seen.insert(neighbour).second) open.push_back(neighbour);
    }
  }
  return count;
}

}  // namespace

PointEdge point_edge(const mesh::Mesh& mesh, const mesh::Edge& edge) {
  const mesh::Point a = mesh.vertices[edge.a].position;
  const mesh::Point b = mesh.vertices[edge.b].position;
  return {std::min(a, b), std::max(a, b)};
}

std::vector<bool> nonmanifold_vertices(const mesh::Mesh& mesh) {
  // The opposite edges of the triangles around a vertex: one path or one cycle where it is manifold.
  std::vector<Graph> links(mesh.vertices.size());
  for (const mesh::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      links[t[k]][t[(k + 1) % 3]].push_back(t[(k + 2) % 3]);
      links[t[k]][t[(k + 2) % 3]].push_back(t[(k + 1) % 3]);
    }
  std::vector<bool> flags;
  for (const Graph& link : links) {
    const bool has_branch =
        std::any_of(link.begin(), link.end(), [](const auto& entry) { return entry.second.size() > 2; });
    flags.push_back(has_branch || component_count(link) != 1);
  }
  return flags;
}

std::size_t border_loop_count(const mesh::Mesh& mesh) {
  Graph border;
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles)) {
    if (!edge.is_border()) continue;
    border[edge.a].push_back(edge.b);
    border[edge.b].push_back(edge.a);
  }
  return component_count(border);
}

void expect_closed(const mesh::Mesh& mesh) {
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles)) {
    ASSERT_EQ(edge.forward, 1U);
    ASSERT_EQ(edge.backward, 1U);
  }
}

}  // namespace colossus::simplify
