#include "pipeline/blocks/long_edges.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

#include "hierarchy/octree.hpp"
#include "mesh/topology.hpp"

namespace colossus::pipeline::blocks {
namespace {

using geometry::Point;
using geometry::Vec3;

constexpr std::int32_t kSpacing = 16;
constexpr std::int64_t kLongest = 50 * kSpacing;
constexpr hierarchy::CubeId kRoot{};

Point random_point(std::mt19937_64& random, std::int32_t most) {
  const auto coordinate = [&] {
    return kSpacing * static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(most / kSpacing));
  };
  const std::int32_t x = coordinate();
  const std::int32_t y = coordinate();
  return {x, y, coordinate()};
}

mesh::Mesh mesh_of(const std::vector<Point>& points, const std::vector<mesh::Triangle>& triangles) {
  mesh::Mesh mesh;
  for (const Point& p : points) mesh.vertices.push_back({p});
  mesh.triangles = triangles;
  return mesh;
}

TEST(LongEdges, MiddlesAreTheNearestPointsOfTheGrid) {
  EXPECT_EQ(middle_on_grid({0, 16, 32}, {16, 32, 64}, 16), (Point{0, 32, 48}));
  EXPECT_EQ(middle_on_grid({0, 1, 2}, {1, 2, 3}, 1), (Point{0, 2, 2}));
  EXPECT_EQ(middle_on_grid({1 << 30, 0, 1 << 30}, {1 << 30, 1 << 30, 0}, 64),
            (Point{1 << 30, 1 << 29, 1 << 29}));
  std::mt19937_64 random(1);
  std::array<int, 2> rounded{};  // down, up
  for (int i = 0; i < 1000; ++i) {
    const Point a = random_point(random, 1 << 30), b = random_point(random, 1 << 30);
    const Point middle = middle_on_grid(a, b, kSpacing);
    EXPECT_EQ(middle, middle_on_grid(b, a, kSpacing));
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t twice = std::int64_t{2} * middle[axis] - a[axis] - b[axis];
      EXPECT_EQ(middle[axis] % kSpacing, 0);
      EXPECT_LE(std::abs(twice), kSpacing);
      EXPECT_GE(middle[axis], std::min(a[axis], b[axis]));
      EXPECT_LE(middle[axis], std::max(a[axis], b[axis]));
      if (twice != 0) ++rounded[twice > 0 ? 1 : 0];
    }
  }
  EXPECT_GT(rounded[0], 500);
  EXPECT_GT(rounded[1], 500);
}

TEST(LongEdges, SplitsUntilNoneIsLeftAndTheSurfaceStaysClosed) {
  std::mt19937_64 random(2);
  for (int round = 0; round < 20; ++round) {
    std::vector<Point> corners;
    for (int i = 0; i < 4; ++i) corners.push_back(random_point(random, 1 << 14));
    mesh::Mesh mesh = mesh_of(corners, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}});
    LongEdgeSplitter splitter(kLongest, kSpacing, mesh);
    EXPECT_GT(splitter.run(kRoot), 6U);
    EXPECT_GT(mesh.triangles.size(), 100U);
    for (const mesh::Edge& edge : mesh::edges(mesh.triangles)) {
      EXPECT_FALSE(edge.is_border());
      EXPECT_LE(hierarchy::max_distance(mesh.vertices[edge.a].position, mesh.vertices[edge.b].position),
                kLongest);
    }
  }
}

// In a mesh with others a triangle becomes what it becomes alone.
TEST(LongEdges, DependsOnTheTriangleAlone) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 20; ++round) {
    std::vector<Point> corners;
    for (int i = 0; i < 4; ++i) corners.push_back(random_point(random, 1 << 13));
    const auto parts_of = [&](const std::vector<mesh::Triangle>& triangles) {
      mesh::Mesh mesh = mesh_of(corners, triangles);
      LongEdgeSplitter splitter(kLongest, kSpacing, mesh);
      splitter.run(kRoot);
      std::vector<std::pair<std::array<Point, 3>, double>> parts;
      for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const mesh::Triangle& t = mesh.triangles[i];
        parts.push_back(
            {{mesh.vertices[t[0]].position, mesh.vertices[t[1]].position, mesh.vertices[t[2]].position},
             splitter.displacement(i)});
      }
      std::sort(parts.begin(), parts.end());
      return parts;
    };
    const auto alone = parts_of({{0, 1, 2}}), other = parts_of({{1, 0, 3}}),
               both = parts_of({{1, 0, 3}, {0, 1, 2}});
    EXPECT_EQ(both.size(), alone.size() + other.size());
    EXPECT_TRUE(std::includes(both.begin(), both.end(), alone.begin(), alone.end()));
    EXPECT_TRUE(std::includes(both.begin(), both.end(), other.begin(), other.end()));
  }
}

TEST(LongEdges, NoPartIsFartherFromItsTriangleThanItsDisplacement) {
  std::mt19937_64 random(4);
  double farthest = 0.0;
  for (int round = 0; round < 20; ++round) {
    const std::array<Point, 3> corners{random_point(random, 1 << 14), random_point(random, 1 << 14),
                                       random_point(random, 1 << 14)};
    mesh::Mesh mesh = mesh_of({corners[0], corners[1], corners[2], {0, 0, 0}, {0, 0, 16}, {0, 16, 0}},
                              {{3, 4, 5}, {0, 1, 2}});
    LongEdgeSplitter splitter(kLongest, kSpacing, mesh);
    splitter.run(kRoot);
    EXPECT_EQ(splitter.displacement(0), 0.0) << "not split";
    for (std::uint32_t i = 1; i < mesh.triangles.size(); ++i) {
      const auto at = [&](std::size_t k) {
        return geometry::to_vec3(mesh.vertices[mesh.triangles[i][k]].position);
      };
      for (int sample = 0; sample < 5; ++sample) {
        const double u = static_cast<double>(random() % 101) / 100.0;
        const double v = (1.0 - u) * static_cast<double>(random() % 101) / 100.0;
        const Vec3 p = u * at(0) + v * at(1) + (1.0 - u - v) * at(2);
        const double distance = std::sqrt(
            geometry::distance_to_triangle(p, geometry::to_vec3(corners[0]), geometry::to_vec3(corners[1]),
                                           geometry::to_vec3(corners[2]), HUGE_VAL)
                .squared);
        EXPECT_LE(distance, splitter.displacement(i) + 1e-6);
        farthest = std::max(farthest, distance);
      }
    }
  }
  EXPECT_GT(farthest, 0.5 * kSpacing) << "a case where it matters";
}

// Thinner than the grid: the middles of its long sides fall onto each other, and the pieces stand in line.
TEST(LongEdges, OfWhatCollapsesShortPiecesAreKnown) {
  constexpr auto kStep = static_cast<std::int32_t>(kLongest);
  mesh::Mesh mesh = mesh_of({{0, 0, 0}, {16 * kStep, 0, 0}, {8 * kStep, 0, 0}}, {{0, 1, 2}});
  LongEdgeSplitter splitter(kLongest, kSpacing, mesh);
  splitter.run(kRoot);
  EXPECT_GT(splitter.lost().size(), 0U);
  std::int64_t reached = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> pieces;
  for (const buckets::LostTriangle& lost : splitter.lost()) {
    const auto [least, most] =
        std::minmax({lost.corners[0].position.x, lost.corners[1].position.x, lost.corners[2].position.x});
    EXPECT_LE(most - least, kLongest);
    pieces.emplace_back(least, most);
  }
  for (const mesh::Triangle& t : mesh.triangles) {
    const auto [least, most] = std::minmax(
        {mesh.vertices[t[0]].position.x, mesh.vertices[t[1]].position.x, mesh.vertices[t[2]].position.x});
    pieces.emplace_back(least, most);
  }
  std::sort(pieces.begin(), pieces.end());
  for (const auto& [least, most] : pieces) {
    EXPECT_LE(least, reached);
    reached = std::max(reached, most);
  }
  EXPECT_EQ(reached, 16 * kLongest);
}

}  // namespace
}  // namespace colossus::pipeline::blocks
