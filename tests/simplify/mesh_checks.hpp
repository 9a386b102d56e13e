// What tests ask of a mesh's borders, edges and vertices.
#pragma once

#include <array>
#include <set>
#include <vector>

#include "mesh/topology.hpp"

namespace colossus::simplify {

// The ends of an edge by their positions, in order.
using PointEdge = std::array<mesh::Point, 2>;
PointEdge point_edge(const mesh::Mesh& mesh, const mesh::Edge& edge);

template <typename Predicate>
std::multiset<PointEdge> edges_where(const mesh::Mesh& mesh, const Predicate& predicate) {
  std::multiset<PointEdge> found;
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles))
    if (predicate(edge)) found.insert(point_edge(mesh, edge));
  return found;
}

// One flag per vertex: whether the triangles around it are something else than one fan, open or closed.
std::vector<bool> nonmanifold_vertices(const mesh::Mesh& mesh);

// Number of closed or open chains that the border edges form, joined at shared vertices.
std::size_t border_loop_count(const mesh::Mesh& mesh);

// Every edge has two triangles, of the same orientation.
void expect_closed(const mesh::Mesh& mesh);

}  // namespace colossus::simplify
