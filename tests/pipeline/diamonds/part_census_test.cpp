#include "pipeline/diamonds/part_census.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/vector.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using mesh::Triangle;

constexpr int kBits = 12;

hierarchy::Tetrahedron root() { return hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[0]; }

// A closed torus inside the tetrahedron.
mesh::Mesh torus(std::uint32_t around, std::uint32_t along) {
  mesh::Mesh mesh;
  geometry::Vec3 center{};
  for (const geometry::Point& corner : root().corners) center = center + 0.25 * geometry::to_vec3(corner);
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < along; ++j) {
      const double u = 2 * M_PI * i / around, v = 2 * M_PI * j / along, side = 1 << 26;
      const double r = side * (1 + 0.4 * std::cos(v));
      mesh.vertices.push_back({{static_cast<std::int32_t>(center.x + r * std::cos(u)),
                                static_cast<std::int32_t>(center.y + r * std::sin(u)),
                                static_cast<std::int32_t>(center.z + 0.4 * side * std::sin(v))}});
      const auto at = [&](std::uint32_t a, std::uint32_t b) { return a % around * along + b % along; };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

codec::quantization::Quantized stored(const mesh::Mesh& mesh) {
  return codec::quantization::quantize(mesh, root(), 0, {kBits, false, false});
}

TEST(PartCensus, IsZeroForAClosedSurfaceAndCountsWhatIsWrong) {
  const mesh::Mesh mesh = torus(40, 20);
  const PartCensus closed = take_census(stored(mesh), false);
  EXPECT_EQ(closed.border_edges + closed.nonmanifold_edges + closed.inconsistent_edges, 0U);
  mesh::Mesh open = mesh;
  open.triangles.pop_back();
  EXPECT_EQ(take_census(stored(open), false).border_edges, 3U);
  mesh::Mesh turned = mesh;
  std::swap(turned.triangles[100][1], turned.triangles[100][2]);
  const PartCensus census = take_census(stored(turned), false);
  EXPECT_EQ(census.inconsistent_edges, 3U);
  EXPECT_EQ(census.border_edges, 0U);
}

// Two more triangles at an edge, one in either direction, as where cuts of two sheets fall together.
TEST(PartCensus, FindsEdgesWithTwoTrianglesOnEitherSide) {
  mesh::Mesh mesh = torus(40, 20);
  const Triangle t = mesh.triangles[123];
  const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(mesh.vertices[t[0]]);
  mesh.vertices.back().position.z += 1 << 25;
  mesh.triangles.push_back({t[0], t[1], tip});
  mesh.triangles.push_back({t[1], t[0], tip});
  const codec::quantization::Quantized part = stored(mesh);
  ASSERT_FALSE(part.has_shared_places);
  EXPECT_EQ(take_census(part, true).nonmanifold_edges, 1U);
  EXPECT_EQ(take_census(part, true).border_edges, 0U);
  EXPECT_EQ(take_census(part, false).nonmanifold_edges, 0U);
}

// Random damage: the sum tells whatever the count of all edges finds, and the other way round.
TEST(PartCensus, TheSumAndTheCountAgree) {
  std::size_t damaged = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    mesh::Mesh mesh = torus(20, 12);
    for (std::uint64_t k = random() % 6; k > 0; --k) {
      Triangle& t = mesh.triangles[random() % mesh.triangles.size()];
      if (random() % 2 == 0)
        std::swap(t[0], t[1]);
      else
        mesh.triangles.erase(mesh.triangles.begin() +
                             static_cast<std::ptrdiff_t>(random() % mesh.triangles.size()));
    }
    const codec::quantization::Quantized part = stored(mesh);
    const PartCensus by_sum = take_census(part, true);
    codec::quantization::Quantized other = part;
    other.has_shared_places = true;  // so that edges are counted one by one
    const PartCensus counted = take_census(other, true);
    EXPECT_EQ(by_sum.border_edges, counted.border_edges);
    EXPECT_EQ(by_sum.inconsistent_edges, counted.inconsistent_edges);
    EXPECT_EQ(by_sum.nonmanifold_edges, counted.nonmanifold_edges);
    damaged += counted.border_edges + counted.inconsistent_edges > 0 ? 1 : 0;
  }
  EXPECT_GT(damaged, 30U);
}

TEST(PartCensus, AreaIsThatOfTheTriangles) {
  const mesh::Mesh mesh = torus(200, 100);
  double expected = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return geometry::to_vec3(mesh.vertices[t[k]].position); };
    expected += 0.5 * geometry::length(geometry::cross(at(1) - at(0), at(2) - at(0)));
  }
  EXPECT_NEAR(area_of(stored(mesh).tetrahedron, root(), kBits) / expected, 1.0, 1e-2);
}

}  // namespace
}  // namespace colossus::pipeline::diamonds
