#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "simplify/collapse.hpp"
#include "simplify/mesh_checks.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

TEST(Simplify, KeepsOuterFaceVerticesAndTheEdgesBetweenThem) {
  Region region = make_region(sphere(4, 0.005, 2), kInnerPlanes, kOuterPlanes);
  const Mesh before = region.mesh;
  std::vector<mesh::Vertex> kept;
  for (std::size_t v = 0; v < before.vertices.size(); ++v)
    if ((region.faces[v] & kOuterFace) != 0) kept.push_back(before.vertices[v]);
  ASSERT_GT(kept.size(), 100U);
  const auto is_border = [](const mesh::Edge& edge) { return edge.is_border(); };
  const auto border = edges_where(before, is_border);
  ASSERT_EQ(border.size(), kept.size());

  const Outcome outcome = simplify(region, 0);
  EXPECT_EQ(outcome.locked_vertices, kept.size());
  EXPECT_LT(region.mesh.triangles.size() * 4, before.triangles.size());
  std::vector<mesh::Vertex> found;
  for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v) {
    if ((region.faces[v] & kOuterFace) != 0) found.push_back(region.mesh.vertices[v]);
    EXPECT_EQ((region.faces[v] & kOuterFace) != 0,
              kOuterPlanes[0].side(region.mesh.vertices[v].position) == 0);
  }
  EXPECT_EQ(found, kept);
  EXPECT_EQ(edges_where(region.mesh, is_border), border);
}

TEST(Simplify, KeepsTrianglesInTheirCells) {
  for (const double noise : {0.0, 0.005, 0.03}) {
    Region region = make_region(sphere(4, noise, 3), kInnerPlanes, kOuterPlanes);
    expect_in_cells(region);
    for (int round = 0; round < 3; ++round) {
      simplify(region, region.mesh.triangles.size() / 2);
      expect_in_cells(region);
    }
    for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v)
      for (std::size_t i = 0; i < kInnerPlanes.size(); ++i)
        EXPECT_EQ((region.faces[v] >> i & 1) != 0,
                  kInnerPlanes[i].side(region.mesh.vertices[v].position) == 0);
  }
}

// Where the surface bulges, the quadrics want a vertex farther out than its neighbours are.
TEST(Simplify, PlacesNoVertexOnOrBeyondAFaceThatTheSurfaceDoesNotMeet) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Mesh original = sphere(2, 0.05, seed);
    std::int32_t highest = 0;
    for (mesh::Vertex& vertex : original.vertices) {
      for (int axis = 0; axis < 3; ++axis) vertex.position[axis] /= 1 << 20;
      highest = std::max(highest, vertex.position.x);
    }
    Region region = make_region(original, {{{1, 0, 0}, highest + 1}}, {});
    const std::size_t target = original.triangles.size() / 4;
    EXPECT_LE(simplify(region, target).final_triangles, target);
    expect_in_cells(region);
    for (const mesh::Vertex& vertex : region.mesh.vertices) EXPECT_LE(vertex.position.x, highest);
  }
}

// Otherwise the two sides of a face would not fit together when they are simplified apart.
void expect_polylines_on_faces(const Region& region) {
  std::map<std::array<std::uint32_t, 2>, std::set<std::uint16_t>> cells;
  for (std::size_t i = 0; i < region.cells.size(); ++i) {
    const Triangle& t = region.mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k)
      cells[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}].insert(region.cells[i]);
  }
  for (const Triangle& t : region.mesh.triangles)
    ASSERT_EQ(region.faces[t[0]] & region.faces[t[1]] & region.faces[t[2]], 0U);
  for (const auto& [edge, around] : cells) {
    const bool is_on_face = (region.faces[edge[0]] & region.faces[edge[1]]) != 0;
    ASSERT_EQ(around.size(), is_on_face ? 2U : 1U);
  }
}

TEST(Simplify, MeetsInnerFacesInPolylinesOnlyOnATornSheet) {
  // One plane lies along the sheet, which crosses it to and fro.
  const std::vector<Plane> planes{{{1, 0, 0}, kMiddle}, {{0, 0, 1}, kMiddle}};
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Mesh sheet = rough_sheet(12, 8, 1.0, seed);
    std::mt19937_64 random(seed);
    if (seed % 2 == 0) std::erase_if(sheet.triangles, [&](const Triangle&) { return random() % 6 == 0; });
    Region region = make_region(sheet, planes, {});
    expect_polylines_on_faces(region);
    for (int round = 0; round < 3; ++round) {
      simplify(region, round < 2 ? region.mesh.triangles.size() / 2 : 0);
      expect_polylines_on_faces(region);
      expect_in_cells(region);
    }
  }
}

TEST(Simplify, MeetsInnerFacesInPolylinesOnlyAndStaysClosed) {
  for (const double noise : {0.0, 0.005, 0.03}) {
    Region region = make_region(sphere(4, noise, 4), kInnerPlanes, {});
    expect_closed(region.mesh);
    expect_polylines_on_faces(region);
    const std::size_t target = region.mesh.triangles.size() / 12;
    simplify(region, target);
    EXPECT_LT(region.mesh.triangles.size(), 2 * target);
    expect_closed(region.mesh);
    expect_polylines_on_faces(region);
  }
}

}  // namespace
}  // namespace colossus::simplify
