#include "simplify/region.hpp"

#include <gtest/gtest.h>

#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

TEST(AngleCounts, CountEachTriangleBySmallestAngle) {
  // Legs 1000 and so wide that the smallest angles are about 2, 10, 20 and 45 degrees; the last has no area.
  Mesh mesh;
  for (const std::int32_t height : {35, 176, 364, 1000, 0}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Point& p : {Point{0, 0, 0}, Point{1000, 0, 0}, Point{0, height, 0}})
      mesh.vertices.push_back(vertex_at(p));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const AngleCounts counts = count_small_angles(mesh);
  EXPECT_EQ(counts.below_5_degrees, 2U);
  EXPECT_EQ(counts.below_15_degrees, 3U);
  EXPECT_EQ(counts.below_30_degrees, 4U);
}

}  // namespace
}  // namespace colossus::simplify
