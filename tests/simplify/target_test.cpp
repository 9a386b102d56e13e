#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>

#include "simplify/collapse.hpp"
#include "simplify/mesh_checks.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

TEST(Simplify, ReachesItsTargetOnANoisySphere) {
  const Mesh original = sphere(4, 0.005, 1);
  for (const std::size_t divisor : {1U, 2U, 4U, 16U, 64U}) {
    Region region = make_region(original, {}, {});
    const std::size_t target = original.triangles.size() / divisor;
    const Outcome outcome = simplify(region, target);
    EXPECT_EQ(outcome.initial_triangles, original.triangles.size());
    EXPECT_EQ(outcome.initial_vertices, original.vertices.size());
    EXPECT_EQ(outcome.locked_vertices, 0U);
    EXPECT_EQ(outcome.final_triangles, region.mesh.triangles.size());
    EXPECT_LE(outcome.final_triangles, target);
    EXPECT_GE(outcome.final_triangles + 2, target);  // each collapse takes two
    EXPECT_EQ(region.faces.size(), region.mesh.vertices.size());
    EXPECT_EQ(region.mesh.vertices.size() * 2,
              region.mesh.triangles.size() + 4);  // still a sphere, nothing unused
    expect_closed(region.mesh);
  }
}

// Octahedra, the largest first: costs grow with the fourth power of their size.
constexpr std::int32_t kOctahedra = 40;
Mesh octahedra(std::int32_t unit) {
  Mesh shapes;
  for (std::int32_t i = 0; i < kOctahedra; ++i) {
    Mesh shape;
    const std::int32_t r = unit * (5 * kOctahedra - i);
    for (const Point& p : {Point{r, 0, 0}, {0, r, 0}, {-r, 0, 0}, {0, -r, 0}, {0, 0, r}, {0, 0, -r}})
      shape.vertices.push_back(vertex_at({1'000'000 * (i + 1) + p.x, 1'000'000 + p.y, 1'000'000 + p.z}));
    shape.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                       {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
    append(shapes, shape);
  }
  return shapes;
}

TEST(Simplify, ChangesTheSmallestOfSimilarShapesFirst) {
  for (std::int32_t unit = 500; unit < 1000; unit += 50) {
    SCOPED_TRACE(testing::Message() << "unit " << unit);
    const Mesh shapes = octahedra(unit);
    Region region = make_region(shapes, {}, {});
    simplify(region, shapes.triangles.size() - 20);
    std::array<int, kOctahedra> triangles{};
    for (const Triangle& t : region.mesh.triangles)
      ++triangles.at(static_cast<std::size_t>(region.mesh.vertices[t[0]].position.x + 500'000) / 1'000'000 -
                     1);
    EXPECT_LT(triangles.back(), 8);
    EXPECT_TRUE(std::is_sorted(triangles.begin(), triangles.end(), std::greater<>()));
    EXPECT_EQ(triangles[kOctahedra - 12], 8);
  }
}

// The cheapest collapses of a flat sheet cost nothing; in the end all of these are illegal at its jagged
// border.
TEST(Simplify, HalvesAFlatSheetAgainAndAgain) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Region region = make_region(rough_sheet(24, 24, 0.0, seed), {}, {});
    region.samples.clear();
    for (std::size_t target = region.mesh.triangles.size() / 2; target >= 36; target /= 2)
      EXPECT_LE(simplify(region, target).final_triangles, target);
  }
}

TEST(Simplify, DoesTheSameTwice) {
  const Region start = make_region(sphere(4, 0.01, 9), kInnerPlanes, kOuterPlanes);
  Region first = start;
  Region second = start;
  const Outcome first_outcome = simplify(first, start.mesh.triangles.size() / 3);
  const Outcome second_outcome = simplify(second, start.mesh.triangles.size() / 3);
  EXPECT_EQ(first.mesh.vertices, second.mesh.vertices);
  EXPECT_EQ(first.mesh.triangles, second.mesh.triangles);
  EXPECT_EQ(first.faces, second.faces);
  EXPECT_EQ(first.cells, second.cells);
  EXPECT_EQ(first_outcome.deviation, second_outcome.deviation);
  ASSERT_EQ(first.samples.size(), second.samples.size());
  for (std::size_t i = 0; i < first.samples.size(); ++i) {
    EXPECT_EQ(first.samples[i].anchor, second.samples[i].anchor);
    EXPECT_EQ(first.samples[i].distance, second.samples[i].distance);
    EXPECT_EQ(first.samples[i].cell, second.samples[i].cell);
  }
}

TEST(Simplify, LeavesSomethingOfEverySphere) {
  Mesh spheres;
  for (int i = 0; i < 5; ++i) {
    Mesh small = sphere(2, 0.01, static_cast<std::uint64_t>(i));
    for (mesh::Vertex& vertex : small.vertices)
      for (int axis = 0; axis < 3; ++axis)
        vertex.position[axis] = vertex.position[axis] / 16 + (axis == 0 ? i * (kMiddle / 4) : 0);
    append(spheres, small);
  }
  Region region = make_region(spheres, {}, {});
  simplify(region, 0);
  expect_closed(region.mesh);
  EXPECT_LT(region.mesh.triangles.size(), spheres.triangles.size() / 4);
  std::array<std::set<std::uint32_t>, 5> left;
  for (std::uint32_t v = 0; v < region.mesh.vertices.size(); ++v)
    left.at(static_cast<std::size_t>(region.mesh.vertices[v].position.x / (kMiddle / 4))).insert(v);
  for (const auto& vertices : left) EXPECT_GE(vertices.size(), 4U);
}

}  // namespace
}  // namespace colossus::simplify
