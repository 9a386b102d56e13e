#include "pipeline/diamonds/cut_remains.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/lattice.hpp"
#include "geometry/vector.hpp"
#include "mesh/clip.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using geometry::Point;
using geometry::Vec3;
using mesh::Triangle;

// Cuts the root tetrahedron's mesh down to a level, as a build does, and welds what is in each tetrahedron.
void cut(const hierarchy::Tetrahedron& tetrahedron, mesh::Mesh&& mesh, int levels,
         std::vector<mesh::Mesh>& cells, std::uint64_t& pairs) {
  if (mesh.triangles.empty()) return;
  if (levels == 0) {
    pairs += weld_cut(tetrahedron, mesh);
    for (const mesh::Vertex& v : mesh.vertices) EXPECT_TRUE(tetrahedron.contains(v.position));
    cells.push_back(std::move(mesh));
    return;
  }
  auto halves = mesh::split(mesh, tetrahedron.bisector());
  for (int end : {0, 1})
    cut(tetrahedron.child(end), std::move(halves[static_cast<std::size_t>(end)]), levels - 1, cells, pairs);
}

double distance(const Vec3& p, const std::vector<mesh::Mesh>& cells) {
  double squared = INFINITY;
  for (const mesh::Mesh& mesh : cells)
    for (const Triangle& t : mesh.triangles) {
      const auto at = [&](std::size_t k) { return geometry::to_vec3(mesh.vertices[t[k]].position); };
      squared = std::min(squared, geometry::distance_to_triangle(p, at(0), at(1), at(2), squared).squared);
    }
  return std::sqrt(squared);
}

// Needles of a few lattice units: wherever planes cross them, all of their length is there.
TEST(CutRemains, NeedlesKeepTheirLength) {
  const hierarchy::Tetrahedron root = hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[0];
  std::uint64_t pairs = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto inside = [&] {
      for (;;) {
        Point p;
        for (int axis = 0; axis < 3; ++axis)
          p[axis] = static_cast<std::int32_t>(random() % (1U << 27)) * geometry::kInputSpacing +
                    geometry::kInputResidue[static_cast<std::size_t>(axis)];
        if (root.contains(p)) return p;
      }
    };
    mesh::Mesh needle;
    const Point base = inside(), tip = inside();
    Point beside = base;
    beside[static_cast<int>(seed % 3)] += geometry::kInputSpacing;
    for (const Point& p : {base, beside, tip}) needle.vertices.push_back({p});
    needle.triangles = {{0, 1, 2}};
    std::vector<mesh::Mesh> cells;
    cut(root, mesh::Mesh(needle), 12, cells, pairs);
    const Vec3 a = geometry::to_vec3(base), b = geometry::to_vec3(tip);
    for (int i = 0; i <= 200; ++i)
      EXPECT_LE(distance(a + (i / 200.0) * (b - a), cells), 2.0 * geometry::kInputSpacing);
  }
  EXPECT_GT(pairs, 10U);
}

TEST(CutRemains, NothingIsAddedWhereTheSurfaceGoesOn) {
  const hierarchy::Tetrahedron root = hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[0];
  Vec3 center{};
  for (const Point& corner : root.corners) center = center + 0.25 * geometry::to_vec3(corner);
  const Point a{static_cast<std::int32_t>(center.x), static_cast<std::int32_t>(center.y),
                static_cast<std::int32_t>(center.z)};
  mesh::Mesh mesh;
  for (const Point& p : {a, Point{a.x + 1000, a.y, a.z}, Point{a.x, a.y + 1000, a.z}, a})
    mesh.vertices.push_back({p});
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}};
  EXPECT_EQ(weld_cut(root, mesh), 0U);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  // Alone, the same segment is all that there is.
  mesh.triangles = {{0, 1, 1}};
  EXPECT_EQ(weld_cut(root, mesh), 1U);
  EXPECT_EQ(mesh.triangles.size(), 2U);
}

}  // namespace
}  // namespace colossus::pipeline::diamonds
