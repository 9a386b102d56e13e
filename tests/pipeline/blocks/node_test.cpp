// One block of cubes as a task, without the levels around it.
#include "pipeline/blocks/node.hpp"

#include <gtest/gtest.h>

#include "pipeline/test_build.hpp"

namespace colossus::pipeline::blocks {
namespace {

using geometry::Point;

// Triangles over the edge from vertex 0 to 1; every other one looks the other way if they are mixed.
mesh::Mesh pair_of_triangles(bool is_mixed) {
  const std::int32_t unit = geometry::kRootSide / 8;
  mesh::Mesh mesh;
  for (const Point& p : {Point{unit, unit, unit}, Point{2 * unit, unit, unit}, Point{unit, 2 * unit, unit},
                         Point{unit, 0, unit}})
    mesh.vertices.push_back({p, {}, 0, {}});
  mesh.triangles = {{0, 1, 2}, is_mixed ? mesh::Triangle{0, 1, 3} : mesh::Triangle{1, 0, 3}};
  return mesh;
}

TEST(BlocksNode, TheRootIsStoredWithItsErrorAndItsEdgesThatLookBothWays) {
  const CommonFolder folder;
  const TestBuild build(folder);
  NodeSettings settings;
  settings.grid = {0, 16};
  settings.codec = &codec::codecs()[0];
  settings.block_size = 4;
  settings.rounding_error = 0.5;
  for (const bool is_mixed : {false, true}) {
    NodeTask task;
    const nodes::SampledMesh content{pair_of_triangles(is_mixed), {}};
    task.cubes.push_back({store_cube(build.workspace(), {}, content, 3.0), 7.0});
    const NodeResult result = build_block(build.workspace(), settings, task);
    ASSERT_EQ(result.nodes.size(), 1U);
    EXPECT_TRUE(result.parents.empty());
    const facts::FinishedNode& node = result.nodes[0];
    EXPECT_EQ(node.statistics.inconsistent_edges, is_mixed ? 1U : 0U);
    EXPECT_EQ(node.row.error, 7.0);
    EXPECT_EQ(node.row.flags, container::kNodeIsLeaf) << "level 0 is the deepest here";
    EXPECT_EQ(node.displacement, settings.input_error(3.0));
    EXPECT_GT(node.area, 0.0);
    EXPECT_EQ(node.row.triangles, 2U);
  }
}

}  // namespace
}  // namespace colossus::pipeline::blocks
