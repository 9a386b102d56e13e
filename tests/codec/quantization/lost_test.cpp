// Nothing of a tetrahedron's surface is lost to quantisation: collapsed triangles, crumbs, wires, fins.
#include "codec/quantization/lost.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codec/coded/places.hpp"
#include "codec/quantization/quantize.hpp"
#include "geometry/vector.hpp"
#include "mesh/topology.hpp"

namespace colossus::codec::quantization {
namespace {

using geometry::Point;
using geometry::Vec3;
using hierarchy::Tetrahedron;
using mesh::Triangle;
using Random = std::mt19937_64;

constexpr int kBits = 8;

Tetrahedron root() { return hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[0]; }

// Within the root, far from its faces.
Point middle() {
  Vec3 sum{};
  for (const Point& corner : root().corners) sum = sum + geometry::to_vec3(corner);
  return {static_cast<std::int32_t>(sum.x / 4), static_cast<std::int32_t>(sum.y / 4),
          static_cast<std::int32_t>(sum.z / 4)};
}

// A hundredth of a unit of weight along an axis.
constexpr std::int32_t kSmall = (1 << 22) / 100;

Point beside(const Point& p, std::int32_t x, std::int32_t y, std::int32_t z) {
  return {p.x + x, p.y + y, p.z + z};
}

mesh::Mesh mesh_of(const std::vector<Point>& points, const std::vector<Triangle>& triangles) {
  mesh::Mesh mesh;
  for (const Point& p : points) mesh.vertices.push_back({p});
  mesh.triangles = triangles;
  return mesh;
}

std::vector<Vec3> stored_points(const coded::CodedPart& part) {
  std::vector<Vec3> points;
  for (const coded::Weights& weights : part.positions) {
    const coded::ScaledPosition p = coded::scaled_position(weights, root());
    points.push_back({std::ldexp(static_cast<double>(p[0]), -kBits),
                      std::ldexp(static_cast<double>(p[1]), -kBits),
                      std::ldexp(static_cast<double>(p[2]), -kBits)});
  }
  return points;
}

double distance(const Vec3& p, const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  double squared = INFINITY;
  for (const Triangle& t : triangles)
    squared = std::min(
        squared,
        geometry::distance_to_triangle(p, points[t[0]], points[t[1]], points[t[2]], squared).squared);
  return std::sqrt(squared);
}

// The corners, the middles of the edges and the barycentre of each triangle.
std::vector<Vec3> places_on(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  std::vector<Vec3> places;
  for (const Triangle& t : triangles) {
    const Vec3 &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
    places.insert(places.end(),
                  {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (1.0 / 3.0) * (a + b + c)});
  }
  return places;
}

// Both ways: what is stored is the input within the displacement.
void expect_there(const mesh::Mesh& mesh, const Quantized& stored) {
  std::vector<Vec3> before;
  for (const mesh::Vertex& v : mesh.vertices) before.push_back(geometry::to_vec3(v.position));
  const std::vector<Vec3> after = stored_points(stored.tetrahedron);
  ASSERT_FALSE(stored.tetrahedron.triangles.empty());
  const double most = stored.displacement * (1 + 1e-6);
  for (const Vec3& p : places_on(before, mesh.triangles))
    EXPECT_LE(distance(p, after, stored.tetrahedron.triangles), most);
  for (const Vec3& p : places_on(after, stored.tetrahedron.triangles))
    EXPECT_LE(distance(p, before, mesh.triangles), most);
}

Quantized stored(const mesh::Mesh& mesh) { return quantize(mesh, root(), 0, {kBits, false, false}); }

void expect_closed(const Quantized& stored) {
  const std::vector<std::uint32_t> welded = coded::first_at_place(stored.tetrahedron.positions);
  std::vector<Triangle> triangles = stored.tetrahedron.triangles;
  for (Triangle& t : triangles)
    for (auto& v : t) v = welded[v];
  for (const mesh::Edge& edge : mesh::edges(triangles)) EXPECT_EQ(edge.forward, edge.backward);
}

// Closed, facing outward.
mesh::Mesh crumb(const Point& at, std::int32_t size) {
  return mesh_of({at, beside(at, size, 0, 0), beside(at, 0, size, 0), beside(at, 0, 0, size)},
                 {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
}

TEST(Lost, ACrumbStaysAsTwoTrianglesBackToBack) {
  const mesh::Mesh mesh = crumb(middle(), kSmall);
  const Quantized result = stored(mesh);
  EXPECT_EQ(result.tetrahedron.triangles.size(), 2U);
  EXPECT_EQ(coded::marks_of(result.tetrahedron.positions), std::vector<std::uint8_t>(3, 0));
  expect_closed(result);
  expect_there(mesh, result);
}

TEST(Lost, ACrumbOnAFaceStaysOffIt) {
  // On the face opposite corner 0, and in it.
  const auto corners = root().corners;
  const Point on_face = geometry::midpoint(geometry::midpoint(corners[1], corners[2]), corners[3]);
  mesh::Mesh mesh = mesh_of({on_face, beside(on_face, 0, 0, 0), beside(on_face, 0, 0, 0)}, {{0, 1, 2}});
  const Vec3 inward = geometry::to_vec3(middle()) - geometry::to_vec3(on_face);
  for (std::size_t v = 1; v < 3; ++v)
    for (int axis = 0; axis < 3; ++axis)
      mesh.vertices[v].position[axis] += static_cast<std::int32_t>(1e-5 * static_cast<double>(v) *
                                                                   (axis == 0   ? inward.x
                                                                    : axis == 1 ? inward.y
                                                                                : inward.z));
  const Quantized result = stored(mesh);
  for (const std::uint8_t marks : coded::marks_of(result.tetrahedron.positions)) EXPECT_EQ(marks, 0);
  expect_there(mesh, result);
}

TEST(Lost, AWireThinnerThanAUnitStaysAllAlong) {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  constexpr std::uint32_t kSteps = 12;
  for (std::uint32_t i = 0; i <= kSteps; ++i) {
    const Point at = beside(middle(), static_cast<std::int32_t>(i) * (1 << 24), 0, 0);
    points.insert(points.end(), {at, beside(at, 0, kSmall, 0), beside(at, 0, 0, kSmall)});
  }
  for (std::uint32_t i = 0; i < kSteps; ++i)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = 3 * i + k, b = 3 * i + (k + 1) % 3;
      triangles.push_back({a, a + 3, b + 3});
      triangles.push_back({a, b + 3, b});
    }
  triangles.push_back({0, 1, 2});
  triangles.push_back({3 * kSteps, 3 * kSteps + 2, 3 * kSteps + 1});
  const mesh::Mesh mesh = mesh_of(points, triangles);
  const Quantized result = stored(mesh);
  EXPECT_EQ(result.tetrahedron.triangles.size(), 2U * kSteps);
  expect_closed(result);
  expect_there(mesh, result);
}

TEST(Lost, APlateThinnerThanAUnitKeepsBothSides) {
  const Point a = middle(), b = beside(a, 1 << 27, 0, 0), c = beside(a, 0, 1 << 27, 0);
  const mesh::Mesh mesh =
      mesh_of({a, b, c, beside(a, 0, 0, kSmall), beside(b, 0, 0, kSmall), beside(c, 0, 0, kSmall)},
              {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}});
  const Quantized result = stored(mesh);
  EXPECT_EQ(result.tetrahedron.triangles.size(), 2U);
  expect_closed(result);
  expect_there(mesh, result);
}

TEST(Lost, AThinFinGoesAndTheDisplacementKnows) {
  // Two triangles that stand up from the edge between two others by less than a unit, of quarters of one.
  const Point a = middle(), b = beside(a, 1 << 27, 0, 0);
  const Point m = beside(a, 1 << 26, 0, 3 << 20);
  const mesh::Mesh with =
      mesh_of({a, b, beside(a, 0, 1 << 27, 0), beside(a, 0, -(1 << 27), 0), m, beside(m, 0, kSmall / 10, 0)},
              {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}, {0, 4, 5}, {4, 1, 5}});
  const Quantized result = stored(with);
  EXPECT_EQ(result.tetrahedron.triangles.size(), 2U);
  expect_there(with, result);
  mesh::Mesh without = with;
  without.triangles.resize(2);
  EXPECT_GT(result.displacement, stored(without).displacement);
}

// Whatever falls together, and however little of it there is.
TEST(Lost, WhateverTheTrianglesTheirSurfaceIsThere) {
  std::size_t lost = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    std::vector<Point> points;
    const auto offset = [&](int bits) {
      return static_cast<std::int32_t>(random() % (std::uint64_t{1} << bits)) - (1 << (bits - 1));
    };
    // Some places, with several points each that quantisation may bring together.
    for (int place = 0; place < 5; ++place) {
      const Point at = beside(middle(), offset(27), offset(27), offset(27));
      for (int k = 0; k < 3; ++k) points.push_back(beside(at, offset(20), offset(20), offset(20)));
    }
    std::vector<Triangle> triangles;
    const std::size_t count = 1 + random() % 12;
    while (triangles.size() < count) {
      const auto pick = [&] { return static_cast<std::uint32_t>(random() % points.size()); };
      const Triangle t{pick(), pick(), pick()};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    mesh::Mesh mesh = mesh_of(points, triangles);
    mesh::weld(mesh);
    const Quantized result = stored(mesh);
    lost += result.tetrahedron.triangles.size() < mesh.triangles.size() ? 1 : 0;
    expect_there(mesh, result);
  }
  EXPECT_GT(lost, 100U);
}

}  // namespace
}  // namespace colossus::codec::quantization
