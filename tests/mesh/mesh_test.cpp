#include "mesh/mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "mesh/topology.hpp"

namespace colossus::mesh {
namespace {

Vertex at(std::int32_t x, std::int32_t y, std::int32_t z) {
  Vertex v;
  v.position = {x, y, z};
  return v;
}

TEST(Weld, MergesEqualPositionsAndDropsDegenerateTriangles) {
  Mesh mesh{{at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(1, 0, 0), at(0, 1, 0), at(1, 1, 0), at(9, 9, 9)},
            {{0, 1, 2}, {3, 5, 4}, {1, 3, 5}}};
  std::vector<std::uint32_t> order;
  weld(mesh, &order);
  EXPECT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
}

TEST(Topology, CountsBordersAndDirections) {
  const std::vector<Triangle> square{{0, 1, 2}, {1, 3, 2}};
  const auto found = edges(square);
  EXPECT_EQ(found.size(), 5U);
  EXPECT_EQ(std::count_if(found.begin(), found.end(), [](const Edge& e) { return e.is_border(); }), 4);
  for (const Edge& e : found)
    if (!e.is_border()) {
      EXPECT_EQ(e.forward, 1U);
      EXPECT_EQ(e.backward, 1U);
    }
}

TEST(Topology, CountsAllTrianglesOfAnEdge) {
  const std::vector<Triangle> sheets{{5, 6, 7}, {6, 5, 8}, {5, 6, 9}};
  const auto found = edges(sheets);
  ASSERT_EQ(found.size(), 7U);
  EXPECT_TRUE(found[0].is_nonmanifold());
  EXPECT_EQ(found[0].forward, 2U);
  EXPECT_EQ(found[0].backward, 1U);
  EXPECT_EQ(std::count_if(found.begin(), found.end(), [](const Edge& e) { return e.is_nonmanifold(); }), 1);
}

TEST(Interpolate, IsSymmetricAndExactAtTheEnds) {
  Vertex a = at(0, 0, 0);
  Vertex b = at(1, 1, 1);
  a.color = {0, 10, 255, 7};
  b.color = {255, 11, 0, 7};
  a.normal = {-32767, 5, 0};
  EXPECT_EQ(interpolate(a, b, 0, 9).color, a.color);
  EXPECT_EQ(interpolate(a, b, 9, 9).normal, b.normal);
  for (int t = 0; t <= 9; ++t) EXPECT_EQ(interpolate(a, b, t, 9).color, interpolate(b, a, 9 - t, 9).color);
}

}  // namespace
}  // namespace colossus::mesh
