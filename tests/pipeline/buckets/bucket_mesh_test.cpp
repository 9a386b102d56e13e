// What a bucket makes of copies, of triangles that lattice or rounding lets coincide, and of those that
// collapse.
#include "pipeline/buckets/bucket_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "geometry/vector.hpp"
#include "pipeline/facts/fingerprint.hpp"

namespace colossus::pipeline::buckets {
namespace {

using geometry::Point;
using mesh::Triangle;

constexpr CubeId kRoot{};

mesh::Vertex vertex_at(std::int32_t x, std::int32_t y, std::int32_t z, std::uint16_t fingerprint = 0) {
  mesh::Vertex vertex;
  vertex.position = {8 * x + 1, 8 * y + 2, 8 * z + 4};
  vertex.fingerprint = fingerprint;
  return vertex;
}

ingest::Piece piece_of(const std::vector<mesh::Vertex>& vertices, const std::vector<Triangle>& triangles) {
  ingest::Piece piece;
  piece.vertices = vertices;
  piece.triangles = triangles;
  for (std::uint64_t v = 0; v < vertices.size(); ++v) piece.numbers.push_back(v);
  return piece;
}

TEST(Fingerprint, SurvivesScratchAndTellsCoordinatesApart) {
  std::mt19937_64 random(1);
  std::set<std::uint16_t> different;
  for (int i = 0; i < 1000; ++i) {
    const auto coordinate = [&] { return static_cast<std::int32_t>(random() % (1U << 27)); };
    mesh::Vertex vertex = vertex_at(coordinate(), coordinate(), coordinate());
    vertex.fingerprint = facts::fingerprint_of({1.0, 2.0, 3.0 + i * 1e-15});
    different.insert(vertex.fingerprint);
    mesh::Vertex read;
    facts::take_apart(facts::with_fingerprint(vertex.position, vertex.fingerprint), read);
    EXPECT_EQ(read.position, vertex.position);
    EXPECT_EQ(read.fingerprint, vertex.fingerprint);
  }
  EXPECT_GT(different.size(), 400U);
  EXPECT_EQ(facts::fingerprint_of({0.0, -0.0, 1.0}), facts::fingerprint_of({-0.0, 0.0, 1.0}));
}

TEST(BucketMesh, KeepsTheFirstOfCopiesWhicheverWayTheOthersLook) {
  const std::vector<mesh::Vertex> vertices{vertex_at(0, 0, 0), vertex_at(9, 0, 0), vertex_at(0, 9, 0),
                                           vertex_at(0, 0, 0), vertex_at(9, 0, 0), vertex_at(0, 9, 0)};
  BucketMesh mesh({}, kRoot, {}, piece_of(vertices, {{0, 2, 1}, {0, 1, 2}, {3, 4, 5}, {5, 4, 3}, {1, 0, 2}}));
  EXPECT_EQ(mesh.mesh().triangles, (std::vector<Triangle>{{0, 1, 2}}));
  EXPECT_EQ(mesh.mesh().vertices[1].position, vertices[2].position);
  EXPECT_EQ(mesh.counts().opposites, 2U);
  EXPECT_EQ(mesh.counts().duplicates, 2U);
  EXPECT_EQ(mesh.counts().input.border, 3U);
  EXPECT_EQ(mesh.counts().triangles, 1U);
}

TEST(BucketMesh, WhatOnlyTheLatticeLetsCoincideIsNoCopy) {
  // The same places on the lattice, other coordinates in the input.
  const std::vector<mesh::Vertex> vertices{vertex_at(0, 0, 0, 1), vertex_at(9, 0, 0, 2),
                                           vertex_at(0, 9, 0, 3), vertex_at(0, 0, 0, 4),
                                           vertex_at(9, 0, 0, 5), vertex_at(0, 9, 0, 6)};
  BucketMesh mesh({}, kRoot, {}, piece_of(vertices, {{0, 1, 2}, {3, 5, 4}, {3, 4, 5}, {4, 5, 3}}));
  EXPECT_EQ(mesh.mesh().triangles.size(), 2U);
  EXPECT_EQ(mesh.counts().opposites, 2U) << "the third and the fourth are the second, turned over";
  EXPECT_EQ(mesh.counts().duplicates, 0U);
  EXPECT_TRUE(mesh.lost().empty());
}

double distance(const geometry::Vec3& p, const mesh::Mesh& mesh) {
  double squared = INFINITY;
  for (const Triangle& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return geometry::to_vec3(mesh.vertices[t[k]].position); };
    squared = std::min(squared, geometry::distance_to_triangle(p, at(0), at(1), at(2), squared).squared);
  }
  return std::sqrt(squared);
}

// Rounding moves by half the diagonal of the grid; what stands for lost triangles is at most one step
// farther.
TEST(BucketMesh, WhateverRoundingTakesTheSurfaceIsThere) {
  constexpr std::int32_t kSpacing = 256;
  std::size_t lost = 0, revived = 0, fins = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::vector<mesh::Vertex> vertices;
    const auto pick = [&](std::uint64_t most) { return static_cast<std::int32_t>(random() % most); };
    for (int place = 0; place < 5; ++place) {
      const Point at{1000 + pick(400), 1000 + pick(400), 1000 + pick(400)};
      for (int k = 0; k < 3; ++k)
        vertices.push_back(vertex_at(at.x + pick(12), at.y + pick(12), at.z + pick(12)));
    }
    std::vector<Triangle> triangles;
    for (std::size_t count = 1 + random() % 14; triangles.size() < count;) {
      const Triangle t{static_cast<std::uint32_t>(random() % 15), static_cast<std::uint32_t>(random() % 15),
                       static_cast<std::uint32_t>(random() % 15)};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    BucketMesh bucket({kSpacing}, kRoot, {}, piece_of(vertices, triangles));
    mesh::Mesh mesh = bucket.mesh();
    revived += revive_lost(bucket.lost(), kSpacing, kRoot, mesh).pairs;
    lost += bucket.lost().size();
    for (const LostTriangle& triangle : bucket.lost()) fins += triangle.is_fin() ? 1 : 0;
    const double most = std::sqrt(3.0) * kSpacing + 1.0;
    for (const Triangle& t : triangles) {
      geometry::Vec3 middle{};
      for (const auto v : t) {
        const geometry::Vec3 p = geometry::to_vec3(vertices[v].position);
        EXPECT_LE(distance(p, mesh), most);
        middle = middle + (1.0 / 3.0) * p;
      }
      EXPECT_LE(distance(middle, mesh), most);
    }
    const EdgeCensus counted = census_of_edges(bucket.mesh().triangles, bucket.mesh().vertices, {}, kRoot);
    EXPECT_EQ(bucket.counts().finest.border, counted.border);
    EXPECT_EQ(bucket.counts().finest.nonmanifold, counted.nonmanifold);
    EXPECT_EQ(bucket.counts().finest.inconsistent, counted.inconsistent);
  }
  EXPECT_GT(lost, 300U);
  EXPECT_GT(revived, 50U);
  EXPECT_GT(fins, 0U);
}

TEST(BucketMesh, AFinThatRoundingFoldsFlatGoesWithBothSides) {
  constexpr std::int32_t kSpacing = 64;
  // Stands up from the edge between two triangles, by less than half a step, and is thinner than that.
  const std::vector<mesh::Vertex> vertices{vertex_at(800, 800, 800),  vertex_at(960, 888, 800),
                                           vertex_at(800, 1200, 800), vertex_at(960, 400, 800),
                                           vertex_at(880, 843, 802),  vertex_at(881, 843, 803)};
  BucketMesh mesh({kSpacing}, kRoot, {},
                  piece_of(vertices, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}, {0, 4, 5}, {4, 1, 5}}));
  EXPECT_EQ(mesh.mesh().triangles.size(), 2U);
  EXPECT_EQ(mesh.counts().finest.nonmanifold, 0U);
  EXPECT_EQ(mesh.counts().input.nonmanifold, 1U);
  double height = 0.0;
  for (const LostTriangle& lost : mesh.lost()) height = std::max(height, lost.displacement);
  EXPECT_GT(height, 0.0);
  EXPECT_LE(height, std::sqrt(3.0) / 2.0 * kSpacing);
}

}  // namespace
}  // namespace colossus::pipeline::buckets
