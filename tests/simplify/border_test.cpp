#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "simplify/collapse.hpp"
#include "simplify/mesh_checks.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

std::set<Point> border_points(const Mesh& mesh) {
  std::set<Point> points;
  for (const PointEdge& edge : edges_where(mesh, [](const mesh::Edge& e) { return e.is_border(); }))
    points.insert(edge.begin(), edge.end());
  return points;
}

TEST(Simplify, KeepsTheStraightBorderOfAnOpenGridStraight) {
  const Mesh original = wavy_grid(50);
  Region region = make_region(original, kInnerPlanes, {});
  std::array<std::int32_t, 2> low{geometry::kRootSide, geometry::kRootSide};
  std::array<std::int32_t, 2> high{0, 0};
  for (const mesh::Vertex& vertex : original.vertices)
    for (int axis = 0; axis < 2; ++axis) {
      auto& least = low[static_cast<std::size_t>(axis)];
      auto& most = high[static_cast<std::size_t>(axis)];
      least = std::min(least, vertex.position[axis]);
      most = std::max(most, vertex.position[axis]);
    }
  const std::set<Point> border_before = border_points(region.mesh);

  simplify(region, region.mesh.triangles.size() / 10);
  const auto after = mesh::edges(region.mesh.triangles);
  EXPECT_EQ(border_loop_count(region.mesh), 1U);
  std::set<Point> border_after;
  for (const mesh::Edge& edge : after) {
    EXPECT_FALSE(edge.is_nonmanifold());
    if (!edge.is_border()) continue;
    const PointEdge ends = point_edge(region.mesh, edge);
    border_after.insert(ends.begin(), ends.end());
    bool is_on_line = false;
    for (int axis = 0; axis < 2; ++axis)
      for (const std::int32_t line :
           {low[static_cast<std::size_t>(axis)], high[static_cast<std::size_t>(axis)]})
        is_on_line |= ends[0][axis] == line && ends[1][axis] == line;
    EXPECT_TRUE(is_on_line);
  }
  EXPECT_LT(border_after.size() * 2, border_before.size());
  for (const Point& p : border_after) EXPECT_TRUE(border_before.contains(p));
}

TEST(Simplify, LeavesOfAFlatSquareItsCorners) {
  Mesh square = wavy_grid(12);
  for (mesh::Vertex& vertex : square.vertices) vertex.position.z = kMiddle + 4;
  std::set<Point> corners;
  for (const std::size_t v : {0, 12, 12 * 13, 12 * 13 + 12}) corners.insert(square.vertices[v].position);
  Region region = make_region(square, {}, {});
  simplify(region, 2);
  EXPECT_EQ(region.mesh.triangles.size(), 2U);
  EXPECT_EQ(border_points(region.mesh), corners);
}

// A band that winds, narrower than its bends are high: to collapse across it would cost little.
Mesh winding_band(std::uint32_t rows, std::uint64_t seed) {
  constexpr std::uint32_t kColumns = 20;
  Mesh band = rough_sheet(kColumns, rows, 0.0, seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> bend(0.0, 0.02 * geometry::kRootSide);
  for (std::uint32_t column = 0; column <= kColumns; ++column) {
    const double shift = bend(random);
    for (std::uint32_t row = 0; row <= rows; ++row) {
      Point& p = band.vertices[column * (rows + 1) + row].position;
      p = input_point({1.0 * p.x, kMiddle + 0.03 * (p.y - kMiddle) + shift, 1.0 * p.z});
    }
  }
  return band;
}

TEST(Simplify, CollapsesBordersOnlyAlongThemselves) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    // All vertices of every other band lie on its border.
    const Mesh original = winding_band(seed % 2 == 0 ? 1 : 3, seed);
    Region region = make_region(original, {}, {});
    const std::set<Point> before = border_points(region.mesh);
    simplify(region, original.triangles.size() / 2);
    EXPECT_LT(region.mesh.triangles.size(), original.triangles.size());
    for (const Point& p : border_points(region.mesh)) EXPECT_TRUE(before.contains(p));
    EXPECT_EQ(border_loop_count(region.mesh), 1U);
    const auto is_nonmanifold = nonmanifold_vertices(region.mesh);
    EXPECT_EQ(std::count(is_nonmanifold.begin(), is_nonmanifold.end(), true), 0);
  }
}

}  // namespace
}  // namespace colossus::simplify
