#include <gtest/gtest.h>

#include <algorithm>

#include "simplify/collapse.hpp"
#include "simplify/mesh_checks.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

// A sphere and its mirror image about one of its vertices.
Mesh bow_tie(std::uint32_t knot) {
  Mesh mesh = sphere(3, 0.002, 6);
  for (mesh::Vertex& vertex : mesh.vertices) vertex.position = geometry::midpoint(vertex.position, {});
  const Point center = mesh.vertices[knot].position;
  Mesh mirrored = mesh;
  for (mesh::Vertex& vertex : mirrored.vertices)
    for (int axis = 0; axis < 3; ++axis) vertex.position[axis] = 2 * center[axis] - vertex.position[axis];
  for (Triangle& t : mirrored.triangles) std::swap(t[1], t[2]);
  append(mesh, mirrored);
  mesh::weld(mesh);
  return mesh;
}

TEST(Simplify, KeepsABowTieVertex) {
  const std::uint32_t knot = 3 * 64;
  const Point position = geometry::midpoint(sphere(3, 0.002, 6).vertices[knot].position, {});
  Region region = make_region(bow_tie(knot), {}, {});
  const Outcome outcome = simplify(region, region.mesh.triangles.size() / 10);
  EXPECT_EQ(outcome.locked_vertices, 1U);
  EXPECT_LE(outcome.final_triangles, outcome.initial_triangles / 10);
  const auto is_nonmanifold = nonmanifold_vertices(region.mesh);
  for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v)
    EXPECT_EQ(is_nonmanifold[v], region.mesh.vertices[v].position == position);
  EXPECT_EQ(std::count(is_nonmanifold.begin(), is_nonmanifold.end(), true), 1);
  expect_closed(region.mesh);
}

TEST(Simplify, KeepsTheEdgeOfThreeSheets) {
  // The grid, the grid mirrored at its first column, and the grid turned up around it.
  const Mesh grid = wavy_grid(24);
  Mesh sheets;
  for (int sheet = 0; sheet < 3; ++sheet) {
    Mesh copy = grid;
    const std::int32_t line = grid.vertices[0].position.x;
    for (mesh::Vertex& vertex : copy.vertices) {
      Point& p = vertex.position;
      const std::int32_t out = (p.x - line) / 4;
      p = sheet == 2 ? Point{kMiddle, p.y, p.z + out} : Point{kMiddle + (sheet == 0 ? out : -out), p.y, p.z};
    }
    if (sheet == 1)
      for (Triangle& t : copy.triangles) std::swap(t[1], t[2]);
    append(sheets, copy);
  }
  mesh::weld(sheets);
  Region region = make_region(sheets, {}, {});
  const auto is_nonmanifold = [](const mesh::Edge& edge) { return edge.is_nonmanifold(); };
  const auto before = edges_where(region.mesh, is_nonmanifold);
  ASSERT_EQ(before.size(), 24U);
  const Outcome outcome = simplify(region, sheets.triangles.size() / 8);
  EXPECT_LT(outcome.final_triangles, outcome.initial_triangles / 4);
  EXPECT_EQ(edges_where(region.mesh, is_nonmanifold), before);
}

}  // namespace
}  // namespace colossus::simplify
