#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/error.hpp"
#include "pipeline/facts/finished_nodes.hpp"

namespace colossus::pipeline::facts {
namespace {

FinishedNode random_node(std::mt19937_64& random) {
  FinishedNode node;
  node.row.level = static_cast<std::uint32_t>(random() % 6);
  const auto coordinate = [&] { return static_cast<std::int32_t>(random() % 1000); };
  node.row.center = {coordinate(), coordinate(), coordinate()};
  node.row.flags = (random() % 2 == 0 ? container::kNodeIsLeaf : 0U) |
                   (random() % 4 == 0 ? container::kNodeIsAboveLimit : 0U);
  node.row.vertices = static_cast<std::uint32_t>(random() % 1000);
  node.row.triangles = static_cast<std::uint32_t>(random() % 1000);
  node.row.payload_bytes = random() % 1000;
  node.row.stored_bytes = random() % 1000;
  node.row.error = static_cast<double>(random() % 1000);
  node.displacement = static_cast<double>(random() % 1000);
  node.area = static_cast<double>(random() % 1000) / 7.0;
  for (auto& bytes : node.component_bytes) bytes = random() % 1000;
  node.statistics.initial_triangles = random() % 1000;
  node.statistics.target_triangles = random() % 1000;
  node.statistics.reached_triangles = random() % 1000;
  node.statistics.initial_vertices = random() % 1000;
  node.statistics.locked_vertices = random() % 1000;
  node.statistics.angles.below_5_degrees = random() % 1000;
  node.statistics.angles.below_15_degrees = random() % 1000;
  node.statistics.angles.below_30_degrees = random() % 1000;
  node.statistics.inconsistent_edges = random() % 1000;
  node.statistics.finest_border_edges = random() % 1000;
  node.statistics.finest_nonmanifold_edges = random() % 1000;
  return node;
}

// All that a level says, as numbers.
std::vector<double> numbers_of(const LevelStatistics& level) {
  const NodeStatistics& s = level.sums;
  std::vector<double> numbers{level.error, level.displacement};
  for (const std::uint64_t count :
       {level.nodes, level.leaves, level.leaves_above_limit, level.vertices, level.triangles,
        level.payload_bytes, level.stored_bytes, s.initial_triangles, s.target_triangles, s.reached_triangles,
        s.initial_vertices, s.locked_vertices, s.angles.below_5_degrees, s.angles.below_15_degrees,
        s.angles.below_30_degrees, s.inconsistent_edges, s.finest_border_edges, s.finest_nonmanifold_edges})
    numbers.push_back(static_cast<double>(count));
  for (const auto bytes : level.component_bytes) numbers.push_back(static_cast<double>(bytes));
  return numbers;
}

TEST(FinishedNodes, AddsUpItsNodes) {
  std::mt19937_64 random(1);
  std::vector<FinishedNode> nodes;
  for (int i = 0; i < 200; ++i) nodes.push_back(random_node(random));
  FinishedNodes hierarchy;
  for (const FinishedNode& node : nodes) hierarchy.add(node);
  std::vector<std::vector<double>> expected(6);
  std::uint64_t finest = 0;
  for (std::uint32_t l = 0; l < 6; ++l) {
    expected[l].assign(numbers_of({}).size(), 0.0);
    for (const FinishedNode& node : nodes) {
      if (node.row.level != l) continue;
      // What a hierarchy of this node alone says.
      FinishedNodes alone;
      alone.add(node);
      const std::vector<double> own = numbers_of(alone.levels.at(l));
      EXPECT_EQ(own[0], node.row.error);
      EXPECT_EQ(own[1], node.displacement);
      EXPECT_EQ(own[2], 1.0);
      EXPECT_EQ(own[9], static_cast<double>(node.statistics.initial_triangles));
      EXPECT_EQ(own[19], static_cast<double>(node.statistics.finest_nonmanifold_edges));
      for (std::size_t i = 0; i < own.size(); ++i)
        expected[l][i] = i < 2 ? std::max(expected[l][i], own[i]) : expected[l][i] + own[i];
      if ((node.row.flags & container::kNodeIsLeaf) != 0) finest += node.row.triangles;
    }
    EXPECT_EQ(numbers_of(hierarchy.levels.at(l)), expected[l]) << l;
  }
  EXPECT_EQ(hierarchy.finest_triangles(), finest);
}

TEST(FinishedNodes, IsTheSameInWhateverOrderNodesComeOnceItIsSorted) {
  std::mt19937_64 random(2);
  std::vector<FinishedNode> nodes;
  for (int i = 0; i < 500; ++i) nodes.push_back(random_node(random));
  FinishedNodes one;
  for (const FinishedNode& node : nodes) one.add(node);
  std::shuffle(nodes.begin(), nodes.end(), random);
  FinishedNodes other;
  for (const FinishedNode& node : nodes) other.add(node);
  one.sort();
  other.sort();
  for (std::size_t i = 0; i < nodes.size(); ++i) EXPECT_EQ(one.nodes[i].row, other.nodes[i].row);
  EXPECT_EQ(one.finest_area(), other.finest_area()) << "to the last bit";
  for (std::size_t i = 1; i < nodes.size(); ++i)
    EXPECT_LE(std::tie(one.nodes[i - 1].row.level, one.nodes[i - 1].row.center),
              std::tie(one.nodes[i].row.level, one.nodes[i].row.center));
}

TEST(FinishedNodes, TakesStatisticsOfALevelThatHasNoNodeYet) {
  FinishedNodes hierarchy;
  NodeStatistics statistics;
  statistics.locked_vertices = 7;
  hierarchy.add(3, statistics);
  hierarchy.add(3, statistics);
  ASSERT_EQ(hierarchy.levels.size(), 4U);
  EXPECT_EQ(hierarchy.levels[3].sums.locked_vertices, 14U);
  EXPECT_EQ(hierarchy.levels[3].nodes, 0U);
}

TEST(Tolerance, IsRefusedWhereALeafErrsMore) {
  BuildOptions options;
  EXPECT_NO_THROW(require_tolerance(options, 1e9));
  options.tolerance = 0.5;
  EXPECT_NO_THROW(require_tolerance(options, 0.5));
  try {
    require_tolerance(options, 0.501);
    ADD_FAILURE();
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kUsage);
    EXPECT_NE(std::string(error.what()).find("0.501"), std::string::npos);
  }
}

TEST(MissedTarget, IsWarnedOfFromATenthOn) {
  const auto warning = [](std::uint64_t reached) {
    FinishedNodes hierarchy;
    NodeStatistics statistics;
    statistics.target_triangles = 1000;
    statistics.reached_triangles = reached;
    hierarchy.add(1, statistics);
    ::testing::internal::CaptureStderr();
    warn_of_missed_target(hierarchy, 1);
    warn_of_missed_target(hierarchy, 2);
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(warning(0), "");
  EXPECT_EQ(warning(1100), "");
  EXPECT_NE(warning(1101).find("level 1 does not shrink as it should: 1101"), std::string::npos);
}

TEST(FloorTriangles, AreAQuarterOfALeaf) {
  BuildOptions options;
  options.leaf_triangles = 1003;
  EXPECT_EQ(floor_triangles(options), 250U);
}

}  // namespace
}  // namespace colossus::pipeline::facts
