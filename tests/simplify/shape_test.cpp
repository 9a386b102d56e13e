#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "simplify/collapse.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

TEST(Simplify, TurnsNoTriangleOfASmoothSphereInward) {
  for (const bool has_cells : {false, true}) {
    Region region = make_region(sphere(4, 0.0, 5), has_cells ? kInnerPlanes : std::vector<Plane>{}, {});
    simplify(region, region.mesh.triangles.size() / 10);
    for (const Triangle& t : region.mesh.triangles) {
      const Vec3 a = at(region.mesh, t[0]);
      const Vec3 normal = geometry::cross(at(region.mesh, t[1]) - a, at(region.mesh, t[2]) - a);
      EXPECT_GT(geometry::dot(normal, a - kCenter), 0.0);
    }
  }
}

// Twice the area seen from above, below zero for a triangle that faces down.
std::int64_t doubled_area(const Mesh& mesh, const Triangle& t) {
  const Point& a = mesh.vertices[t[0]].position;
  const Point& b = mesh.vertices[t[1]].position;
  const Point& c = mesh.vertices[t[2]].position;
  return std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{b.y - a.y} * (c.x - a.x);
}

// All triangles, before and after each of a few rounds.
void expect_all_face_up(Region& region) {
  for (const Triangle& t : region.mesh.triangles) ASSERT_GT(doubled_area(region.mesh, t), 0);
  const std::size_t initial = region.mesh.triangles.size();
  for (int round = 0; round < 6; ++round) {
    simplify(region, region.mesh.triangles.size() / 2);
    for (const Triangle& t : region.mesh.triangles) EXPECT_GE(doubled_area(region.mesh, t), 0);
  }
  EXPECT_LT(region.mesh.triangles.size() * 4, initial);
}

TEST(Simplify, TurnsNoTriangleOfAFlatSheet) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Region region = make_region(rough_sheet(24, 24, 0.0, seed), {}, {});
    expect_all_face_up(region);
  }
}

TEST(Simplify, KeepsAFlatSheetFlatInWhicheverPlane) {
  for (int axis = 0; axis < 3; ++axis) {
    Mesh sheet = rough_sheet(16, 16, 0.0, 1);
    const std::int32_t height = sheet.vertices[0].position.z;
    for (mesh::Vertex& vertex : sheet.vertices) std::swap(vertex.position[axis], vertex.position.z);
    Region region = make_region(sheet, {}, {});
    EXPECT_LT(simplify(region, 0).final_triangles, sheet.triangles.size() / 4);
    for (const mesh::Vertex& vertex : region.mesh.vertices) EXPECT_EQ(vertex.position[axis], height);
  }
}

TEST(Simplify, TurnsNoSliverOfAFlatSheet) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    // Squeezed so that every other row is a thousandth as high as it is long, or less.
    constexpr std::uint32_t kRows = 24;
    Mesh sheet = rough_sheet(kRows, kRows, 0.0, seed);
    const auto row_y = [](std::uint32_t k) {
      return 0.1 * geometry::kRootSide + 0.8 * geometry::kRootSide / kRows * (k / 2 * 2 + k % 2 * 5e-4);
    };
    for (std::uint32_t v = 0; v < sheet.vertices.size(); ++v) {
      Point& p = sheet.vertices[v].position;
      p = input_point({1.0 * p.x, row_y(v % (kRows + 1)), 1.0 * p.z});
    }
    Region region = make_region(sheet, {}, {});
    expect_all_face_up(region);
  }
}

Vec3 normal_of(const Mesh& mesh, const Triangle& t) {
  const Vec3 normal = geometry::cross(at(mesh, t[1]) - at(mesh, t[0]), at(mesh, t[2]) - at(mesh, t[0]));
  return (1.0 / geometry::length(normal)) * normal;
}

TEST(Simplify, TurnsATriangleByLessThanARightAngleAtATime) {
  std::size_t collapses = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    // Most are so small and rough that even the cheapest collapse turns triangles.
    const std::uint32_t side = seed % 10 == 0 ? 6 : 2;
    Region region = make_region(rough_sheet(side, side, 0.5 * static_cast<int>(seed % 5), seed), {}, {});
    for (;;) {
      // Each triangle in a cell of its own, which tells what became of it.
      const Mesh before = region.mesh;
      std::iota(region.cells.begin(), region.cells.end(), std::uint16_t{0});
      region.cell_planes.assign(region.cells.size(), region.cell_planes[0]);
      region.samples.clear();
      if (simplify(region, before.triangles.size() - 1).final_triangles == before.triangles.size()) break;
      ++collapses;
      for (std::size_t i = 0; i < region.cells.size(); ++i)
        EXPECT_GT(geometry::dot(normal_of(before, before.triangles[region.cells[i]]),
                                normal_of(region.mesh, region.mesh.triangles[i])),
                  0.199);
    }
  }
  EXPECT_GT(collapses, 500U);
}

// A closed octahedron around the middle, n * n triangles on each side: its edges are blunter than the
// greatest turn that a collapse may make.
constexpr std::int32_t kOctahedronUnit = 1 << 20;
Mesh gridded_octahedron(std::int32_t n) {
  Mesh octahedron;
  for (const std::int32_t x : {-1, 1})
    for (const std::int32_t y : {-1, 1})
      for (const std::int32_t z : {-1, 1}) {
        const auto at = [&](std::int32_t i, std::int32_t k) {
          return vertex_at({kMiddle + x * i * kOctahedronUnit, kMiddle + y * k * kOctahedronUnit,
                            kMiddle + z * (n - i - k) * kOctahedronUnit});
        };
        const auto add = [&](const mesh::Vertex& a, const mesh::Vertex& b, const mesh::Vertex& c) {
          const auto first = static_cast<std::uint32_t>(octahedron.vertices.size());
          octahedron.vertices.insert(octahedron.vertices.end(), {a, b, c});
          if (x * y * z > 0)
            octahedron.triangles.push_back({first, first + 1, first + 2});
          else
            octahedron.triangles.push_back({first, first + 2, first + 1});
        };
        for (std::int32_t i = 0; i < n; ++i)
          for (std::int32_t k = 0; i + k < n; ++k) {
            add(at(i, k), at(i + 1, k), at(i, k + 1));
            if (i + k + 2 <= n) add(at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
          }
      }
  mesh::weld(octahedron);
  return octahedron;
}

// All corners on one side of the octahedron.
bool is_on_one_side(const Mesh& mesh, const Triangle& t, std::int32_t n) {
  for (const std::int32_t x : {-1, 1})
    for (const std::int32_t y : {-1, 1})
      for (const std::int32_t z : {-1, 1})
        if (std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
              const Point& p = mesh.vertices[v].position;
              return x * (p.x - kMiddle) + y * (p.y - kMiddle) + z * (p.z - kMiddle) == n * kOctahedronUnit;
            }))
          return true;
  return false;
}

TEST(Simplify, MovesToTheCheaperEndWhereNoVertexMayBePlaced) {
  constexpr std::int32_t kSide = 8;
  Region region = make_region(gridded_octahedron(kSide), {}, {});
  // A cell that claims to lie elsewhere. Vertices move onto their neighbours at no cost but from an edge into
  // a side.
  region.cell_planes[0][0] = {{0, 0, 1}, geometry::kRootSide};
  std::set<Point> before;
  for (const mesh::Vertex& vertex : region.mesh.vertices) before.insert(vertex.position);
  // Only the edges have as many vertices: those of the sides have to go there.
  constexpr std::size_t kTarget = 8 * 4;
  EXPECT_LE(simplify(region, kTarget).final_triangles, kTarget);
  for (const mesh::Vertex& vertex : region.mesh.vertices) EXPECT_TRUE(before.contains(vertex.position));
  for (const Triangle& t : region.mesh.triangles)
    EXPECT_TRUE(is_on_one_side(region.mesh, t, kSide)) << "a triangle across an edge";
}

// --- what goes no further ---

// Many at different places.
Mesh repeated(const std::vector<Point>& points, const std::vector<Triangle>& triangles) {
  Mesh shapes;
  for (std::int32_t i = 0; i < 20; ++i) {
    Mesh shape;
    for (const Point& p : points) shape.vertices.push_back(vertex_at({p.x + 8000 * i, p.y, p.z}));
    shape.triangles = triangles;
    append(shapes, shape);
  }
  return shapes;
}

void expect_left_alone(const Mesh& shapes) {
  Region region = make_region(shapes, {}, {});
  const Mesh before = region.mesh;
  simplify(region, 0);
  EXPECT_EQ(region.mesh.triangles, before.triangles);
  EXPECT_EQ(region.mesh.vertices, before.vertices);
}

TEST(Simplify, LeavesSingleTrianglesAlone) {
  expect_left_alone(repeated({{8, 8, 8}, {808, 8, 8}, {8, 808, 8}}, {{0, 1, 2}}));
}

TEST(Simplify, LeavesTetrahedraAlone) {
  expect_left_alone(repeated({{8, 8, 8}, {808, 8, 8}, {8, 808, 8}, {88, 8, 808}},
                             {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
}

// Two triangles back to back.
TEST(Simplify, LeavesTheThinnestShapesAlone) {
  expect_left_alone(repeated({{8, 8, 8}, {808, 8, 8}, {8, 808, 8}}, {{0, 1, 2}, {2, 1, 0}}));
}

}  // namespace
}  // namespace colossus::simplify
