// Separate pieces: which of them go where the target is not reached, and what stays valid.
#include "simplify/components.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "simplify/brute_force.hpp"
#include "simplify/collapse.hpp"
#include "simplify/mesh_checks.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

// Closed, facing outward, at a point.
Mesh crumb(const Vec3& at, std::int32_t size) {
  const Point p = input_point(at);
  Mesh mesh;
  for (const Point& offset : {Point{0, 0, 0}, Point{size, 0, 0}, Point{0, size, 0}, Point{0, 0, size}})
    mesh.vertices.push_back(vertex_at({p.x + offset.x, p.y + offset.y, p.z + offset.z}));
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

constexpr std::int32_t kCrumb = 1 << 12;
constexpr double kLimit = 1 << 16;

// A sphere, and crumbs in random directions at a height above it.
Mesh sown_sphere(std::size_t count, double height, std::uint64_t seed) {
  Mesh mesh = sphere(3, 0.0, 1);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 to{normal(random), normal(random), normal(random)};
    append(mesh, crumb(kCenter + ((kRadius + height) / geometry::length(to)) * to, kCrumb));
  }
  return mesh;
}

std::vector<std::uint32_t> identity(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  for (std::uint32_t v = 0; v < count; ++v) numbers[v] = v;
  return numbers;
}

struct Dropped {
  Region before;
  Region after;
  std::vector<std::uint32_t> representative;
  std::size_t triangles() const { return after.mesh.triangles.size(); }
};

Dropped dropped(Region region, std::size_t target, double limit) {
  Dropped result;
  result.before = region;
  result.representative = identity(region.mesh.vertices.size());
  drop_components(region, target, limit, result.before.mesh.vertices, result.representative);
  result.after = std::move(region);
  return result;
}

Region half_edge_region(const Mesh& mesh) {
  Region region = make_region(mesh, {}, {});
  region.may_place = false;
  region.cell_planes.clear();
  return region;
}

// Every corner that has gone lies within the limit of what stays.
void expect_within(const Dropped& result, double limit) {
  for (const mesh::Vertex& vertex : result.before.mesh.vertices)
    EXPECT_LE(BruteForce(result.after.mesh).distance(geometry::to_vec3(vertex.position)), limit * (1 + 1e-9));
}

TEST(Components, NearOnesGoAndFarOnesStay) {
  Mesh mesh = sown_sphere(40, 0.4 * kLimit, 2);
  append(mesh, crumb(kCenter, kCrumb));
  const std::size_t of_sphere = sphere(3, 0.0, 1).triangles.size();
  // A sphere of that depth is up to a hundredth of its radius off the round one.
  const double limit = 0.02 * kRadius + kLimit;
  for (const bool may_place : {true, false}) {
    const Dropped result =
        dropped(may_place ? make_region(mesh, {}, {}) : half_edge_region(mesh), of_sphere, limit);
    EXPECT_EQ(result.triangles(), of_sphere + 4) << "the one in the centre is too far from everything";
    expect_within(result, limit);
    expect_closed(result.after.mesh);
    EXPECT_EQ(result.after.mesh.triangles.size(), result.after.cells.size());
    EXPECT_EQ(result.after.mesh.vertices.size(), result.after.faces.size());
    if (may_place) {
      EXPECT_EQ(result.after.mesh.vertices.size(), of_sphere / 2 + 2 + 4);
    }
  }
}

TEST(Components, NoMoreGoThanTheTargetAsksFor) {
  const Mesh mesh = sown_sphere(40, 0.0, 3);
  const std::size_t target = mesh.triangles.size() - 4 * 10;
  EXPECT_EQ(dropped(make_region(mesh, {}, {}), target, kRadius).triangles(), target);
  EXPECT_EQ(dropped(make_region(mesh, {}, {}), mesh.triangles.size(), kRadius).triangles(),
            mesh.triangles.size());
  EXPECT_EQ(dropped(make_region(mesh, {}, {}), 0, 0.0).triangles(), mesh.triangles.size());
}

TEST(Components, OneAlwaysStays) {
  Mesh mesh;
  for (int i = 0; i < 50; ++i) append(mesh, crumb(kCenter + Vec3{16.0 * kCrumb * i, 0, 0}, kCrumb));
  const Dropped all = dropped(make_region(mesh, {}, {}), 0, 1e12);
  EXPECT_EQ(all.triangles(), 4U);
  expect_within(all, 1e12);
  // Neighbours are 15 sizes apart: of two that could go for each other, one stays.
  const double limit = 17.0 * kCrumb;
  const Dropped some = dropped(make_region(mesh, {}, {}), 0, limit);
  EXPECT_LT(some.triangles(), 4U * 30);
  EXPECT_GE(some.triangles(), 4U * 16);
  expect_within(some, limit);
}

TEST(Components, WhatTouchesAFaceStays) {
  const Mesh mesh = sown_sphere(40, 0.0, 4);
  Region region = half_edge_region(mesh);
  region.outer_faces = 1;
  const std::size_t of_sphere = sphere(3, 0.0, 1).triangles.size();
  const std::size_t of_sphere_vertices = of_sphere / 2 + 2;
  // One corner of every second crumb is shared with others.
  for (std::size_t c = 0; c < 40; c += 2) region.faces[of_sphere_vertices + 4 * c + 1] = 1;
  EXPECT_EQ(dropped(region, 0, 0.1 * kRadius).triangles(), of_sphere + 4 * 20);
}

// Every vertex before has one after that is within reach of it, and the triangles that have gone are images
// in which corners coincide: what makes parents valid.
TEST(Components, VerticesBecomeOneWithinReach) {
  const Mesh mesh = sown_sphere(60, 0.3 * kLimit, 5);
  for (const double reach : {2.0 * kCrumb, 0.2 * kRadius}) {
    Region region = half_edge_region(mesh);
    region.reach = static_cast<std::int64_t>(reach);
    const Dropped result = dropped(region, 0, 0.1 * kRadius);
    EXPECT_LT(result.triangles(), mesh.triangles.size() - 4 * 50);
    std::size_t mapped = 0;
    for (std::size_t v = 0; v < result.before.mesh.vertices.size(); ++v) {
      const Point& p = result.before.mesh.vertices[v].position;
      const Point& q = result.after.mesh.vertices.at(result.representative[v]).position;
      for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(p[axis] - q[axis]), region.reach);
    }
    for (const Triangle& t : result.before.mesh.triangles) {
      const Triangle image{result.representative[t[0]], result.representative[t[1]],
                           result.representative[t[2]]};
      mapped += image[0] != image[1] && image[1] != image[2] && image[2] != image[0] ? 1 : 0;
    }
    EXPECT_EQ(mapped, result.triangles());
  }
}

TEST(Components, NeitherTheOrderOfTrianglesNorOfVerticesMatters) {
  const Mesh mesh = sown_sphere(60, 0.5 * kLimit, 6);
  const std::size_t target = mesh.triangles.size() - 4 * 25;
  const auto positions = [&](const Mesh& of) {
    std::vector<std::array<Point, 3>> corners;
    const Dropped result = dropped(make_region(of, {}, {}), target, 0.1 * kRadius);
    for (const Triangle& t : result.after.mesh.triangles) {
      corners.push_back({result.after.mesh.vertices[t[0]].position, result.after.mesh.vertices[t[1]].position,
                         result.after.mesh.vertices[t[2]].position});
      std::sort(corners.back().begin(), corners.back().end());
    }
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  Mesh reversed = mesh;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  EXPECT_EQ(positions(reversed), positions(mesh));
}

// Through the whole simplification: a rough sphere's error reaches the crumbs, a smooth one's does not.
TEST(Components, GoOnlyWithinTheErrorOfTheSimplification) {
  for (const double noise : {0.01, 0.0}) {
    Mesh mesh = sphere(4, noise, 7);
    const std::size_t of_sphere = mesh.triangles.size();
    std::mt19937_64 random(7);
    for (int i = 0; i < 200; ++i)
      append(
          mesh,
          crumb(geometry::to_vec3(mesh.vertices[random() % (of_sphere / 2)].position) + Vec3{8, 8, 8}, 64));
    Region region = make_region(mesh, {}, {});
    const Outcome outcome = simplify(region, 300);
    EXPECT_LE(outcome.final_triangles, 300U);
    EXPECT_EQ(outcome.final_triangles, region.mesh.triangles.size());
    double farthest = 0.0;
    for (const mesh::Vertex& vertex : mesh.vertices)
      farthest = std::max(farthest, BruteForce(region.mesh).distance(geometry::to_vec3(vertex.position)));
    EXPECT_LE(farthest, outcome.deviation);
    for (const SurfaceSample& sample : region.samples) ASSERT_LT(sample.anchor, region.mesh.vertices.size());
  }
}

}  // namespace
}  // namespace colossus::simplify
