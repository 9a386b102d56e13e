// One node as a task, without the levels around it.
#include "pipeline/diamonds/node.hpp"

#include <gtest/gtest.h>

#include <array>

#include "pipeline/test_build.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using geometry::Point;
using hierarchy::Diamond;

constexpr Point kRoot{geometry::kRootSide / 2, geometry::kRootSide / 2, geometry::kRootSide / 2};

// A fan of so many triangles strictly within the tetrahedron.
mesh::Mesh fan_within(const hierarchy::Tetrahedron& tetrahedron, std::uint32_t count) {
  const auto at = [&](std::int64_t a, std::int64_t b, std::int64_t c) {
    const std::array<std::int64_t, 4> weights{a, b, c, 97 - a - b - c};
    Point p;
    for (int axis = 0; axis < 3; ++axis) {
      std::int64_t sum = 0;
      for (std::size_t i = 0; i < 4; ++i) sum += weights[i] * tetrahedron.corners[i][axis];
      p[axis] = static_cast<std::int32_t>(sum / 97);
    }
    return p;
  };
  mesh::Mesh mesh;
  mesh.vertices.push_back({at(16, 16, 16), {}, 0, {}});
  for (std::uint32_t i = 0; i <= count; ++i) {
    mesh.vertices.push_back({at(8 + 2 * static_cast<std::int64_t>(i), 10, 20), {}, 0, {}});
    if (i > 0) mesh.triangles.push_back({0, i, i + 1});
  }
  return mesh;
}

NodeSettings settings_for(std::uint64_t leaf_triangles) {
  NodeSettings settings;
  settings.quantize.normals = settings.quantize.colors = true;
  settings.codec = &codec::codecs()[0];
  settings.leaf_triangles = leaf_triangles;
  settings.input_error = 0.25;
  return settings;
}

// Two tetrahedra of the root with fans of so many triangles.
NodeTask leaf_task(const run::Workspace& workspace, std::array<std::uint32_t, 2> counts) {
  const Diamond diamond = Diamond::at(kRoot);
  NodeTask task;
  task.center = kRoot;
  task.is_leaf = true;
  for (std::uint32_t place = 0; place < 2; ++place) {
    const mesh::Mesh mesh = fan_within(diamond.tetrahedra[place], counts[place]);
    task.parts.push_back({place, 0, counts[place], 0, nodes::store(workspace, {mesh, {}})});
  }
  return task;
}

TEST(DiamondsNode, ALeafWithAFullerTetrahedronThanAllowedIsFlagged) {
  const CommonFolder folder;
  const TestBuild build(folder);
  for (const std::array<std::uint32_t, 2>& counts : {std::array{5U, 8U}, std::array{8U, 5U}}) {
    const NodeTask task = leaf_task(build.workspace(), counts);
    for (const std::uint64_t most : {7, 8, 13}) {
      const container::NodeRow row = build_node(build.workspace(), settings_for(most), task).node.row;
      EXPECT_EQ(row.flags,
                container::kNodeIsLeaf | (most < 8 ? container::kNodeIsAboveLimit : std::uint8_t{0}))
          << most;
      EXPECT_EQ(row.triangles, 13U);
      EXPECT_EQ(row.tetra_mask, 3);
    }
  }
}

TEST(DiamondsNode, AnErrorIsNoLessThanThatOfTheChildrenNorThanWhatMovedTheVertices) {
  const CommonFolder folder;
  const TestBuild build(folder);
  const NodeSettings settings = settings_for(100);
  NodeTask task = leaf_task(build.workspace(), {6, 6});
  const NodeResult leaf = build_node(build.workspace(), settings, task);
  EXPECT_GT(leaf.node.displacement, 0.0);
  EXPECT_EQ(leaf.node.row.error, leaf.node.displacement + settings.input_error);
  EXPECT_TRUE(leaf.tetrahedra.empty());
  task.least_error = 3.0 * leaf.node.row.error;
  EXPECT_EQ(build_node(build.workspace(), settings, task).node.row.error, task.least_error);
}

}  // namespace
}  // namespace colossus::pipeline::diamonds
