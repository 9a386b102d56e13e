#include "simplify/vertex_class.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "mesh/topology.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

TEST(VertexClass, TellsWhatAVertexMayDo) {
  const Region region = make_region(wavy_grid(10), kInnerPlanes, {});
  mesh::Adjacency adjacency;
  adjacency.build(region.mesh.triangles, region.mesh.vertices.size());
  std::vector<bool> is_on_border(region.mesh.vertices.size(), false);
  for (const mesh::Edge& edge : mesh::edges(region.mesh.triangles))
    if (edge.is_border()) is_on_border[edge.a] = is_on_border[edge.b] = true;
  const auto classes = classify_vertices(region, adjacency);
  for (std::size_t v = 0; v < classes.size(); ++v)
    EXPECT_EQ(classes[v], is_on_border[v]        ? VertexClass::kBorder
                          : region.faces[v] != 0 ? VertexClass::kFace
                                                 : VertexClass::kFree);
  Region outer = region;
  outer.outer_faces = 1;
  const auto locked = classify_vertices(outer, adjacency);
  for (std::size_t v = 0; v < locked.size(); ++v) {
    const bool is_outer = (region.faces[v] & 1) != 0;
    EXPECT_EQ(locked[v], is_outer ? VertexClass::kLocked : classes[v]);
  }
}

// Vertex 0 with triangles around it, given by the two other corners of each.
VertexClass class_of(const std::vector<std::array<std::uint32_t, 2>>& opposite) {
  Region region;
  for (std::int32_t i = 0; i < 6; ++i) region.mesh.vertices.push_back(vertex_at({i, i * i, 0}));
  for (const auto& [from, to] : opposite) region.mesh.triangles.push_back({0, from, to});
  region.faces.assign(region.mesh.vertices.size(), 0);
  mesh::Adjacency adjacency;
  adjacency.build(region.mesh.triangles, region.mesh.vertices.size());
  return classify_vertices(region, adjacency)[0];
}

TEST(VertexClass, LocksWhatIsNotOneFan) {
  EXPECT_EQ(class_of({{1, 2}, {2, 3}, {3, 1}}), VertexClass::kFree);
  EXPECT_EQ(class_of({{2, 3}, {1, 2}, {3, 4}}), VertexClass::kBorder);
  EXPECT_EQ(class_of({{1, 2}, {3, 4}}), VertexClass::kLocked);                          // two fans
  EXPECT_EQ(class_of({{1, 2}, {2, 1}, {3, 4}, {4, 3}}), VertexClass::kLocked);          // two closed ones
  EXPECT_EQ(class_of({{1, 2}, {2, 3}, {3, 1}, {4, 5}}), VertexClass::kLocked);          // one of each
  EXPECT_EQ(class_of({{1, 2}, {1, 3}}), VertexClass::kLocked);                          // they face apart,
  EXPECT_EQ(class_of({{1, 3}, {2, 3}}), VertexClass::kLocked);                          // and together
  EXPECT_EQ(class_of({{1, 2}, {2, 3}, {3, 2}}), VertexClass::kLocked);                  // a fin on a fan,
  EXPECT_EQ(class_of({{1, 2}, {2, 3}, {3, 1}, {2, 4}, {4, 5}}), VertexClass::kLocked);  // and another
  EXPECT_EQ(class_of({}), VertexClass::kLocked);
}

}  // namespace
}  // namespace colossus::simplify
