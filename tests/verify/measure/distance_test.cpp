#include "verify/measure/distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/diamonds_fixture.hpp"

namespace colossus::verify::measure {

using namespace support;
namespace {

TEST(Distance, TriangleRegions) {
  const WorldPoint a{0, 0, 0};
  const WorldPoint b{4, 0, 0};
  const WorldPoint c{0, 4, 0};
  EXPECT_DOUBLE_EQ(triangle_distance({1, 1, 3}, a, b, c), 3.0);
  EXPECT_DOUBLE_EQ(triangle_distance({1, 1, 0}, a, b, c), 0.0);
  EXPECT_DOUBLE_EQ(triangle_distance({-3, 0, 4}, a, b, c), 5.0);
  EXPECT_DOUBLE_EQ(triangle_distance({2, -2, 0}, a, b, c), 2.0);
  EXPECT_DOUBLE_EQ(triangle_distance({3, 3, 0}, a, b, c), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(triangle_distance({3, 3, 0}, c, b, a), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(triangle_distance({7, 4, 0}, a, b, b), 5.0);
  EXPECT_DOUBLE_EQ(triangle_distance({3, 4, 0}, a, a, a), 5.0);
}

TEST(Distance, IndexFindsTheNearestOfAllTriangles) {
  const WorldMesh mesh = torus(30, 20);
  const SurfaceIndex index(mesh.surface());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-6, 6);
  for (int round = 0; round < 300; ++round) {
    const WorldPoint p{coordinate(random), coordinate(random), coordinate(random)};
    double least = 1e300;
    for (const auto& t : mesh.triangles)
      least = std::min(least, triangle_distance(p, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]));
    EXPECT_EQ(index.nearest(p).distance, least);
    EXPECT_EQ(index.nearest(p, static_cast<std::uint32_t>(random() % mesh.triangles.size())).distance, least);
  }
}

TEST(Distance, SamplesLieOnTheSurfaceAndAreTheSameForASeed) {
  const WorldMesh mesh = sphere(2);
  const SurfaceIndex index(mesh.surface());
  const auto samples = sample_surface(mesh.surface(), 1000, 5);
  EXPECT_GE(samples.size(), 990U);
  EXPECT_LE(samples.size(), 1000U);
  for (const WorldPoint& p : samples) EXPECT_LT(index.nearest(p).distance, 1e-12);
  EXPECT_EQ(samples, sample_surface(mesh.surface(), 1000, 5));
  EXPECT_NE(samples, sample_surface(mesh.surface(), 1000, 6));
}

TEST(Distance, OneSidedDistancesOfConcentricSpheres) {
  WorldMesh large = sphere(5);
  const WorldMesh small = large;
  for (auto& p : large.points)
    for (double& c : p) c *= 1.25;
  const auto d = surface_distances(large.surface(), small.surface(), 5000);
  EXPECT_NEAR(d.a_to_b.rms, 0.25, 0.002);
  EXPECT_NEAR(d.a_to_b.max, 0.25, 0.002);
  EXPECT_NEAR(d.b_to_a.rms, 0.25, 0.002);
}

// A part of a surface is at no distance from the whole, but not the other way round.
TEST(Distance, IsOneSided) {
  const WorldMesh whole = sphere(3);
  WorldMesh part = whole;
  std::erase_if(part.triangles, [&](const auto& t) { return part.points[t[0]][2] > 0; });
  const auto d = surface_distances(part.surface(), whole.surface(), 2000);
  EXPECT_LT(d.a_to_b.max, 1e-12);
  EXPECT_GT(d.b_to_a.max, 0.5);
}

}  // namespace
}  // namespace colossus::verify::measure
