// What any scheme makes of a closed surface, on any number of ranks, and again when it is resumed.
#include <gtest/gtest.h>

#include <cmath>

#include "container/reader.hpp"
#include "hierarchy/diamond.hpp"
#include "hierarchy/octree.hpp"
#include "pipeline/ingest/join.hpp"
#include "pipeline/nodes/assemble.hpp"
#include "pipeline/nodes/finest_level.hpp"
#include "pipeline/schemes.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline {
namespace {

// A ball with dents, of 2 * around * (rows - 1) triangles and one colour per vertex.
MadeUpFile dented_ball(std::uint32_t around, std::uint32_t rows) {
  MadeUpFile file;
  const double pi = std::acos(-1.0);
  const auto add = [&](double polar, double azimuth) {
    const double radius = 10.0 + 0.3 * std::sin(9.0 * polar) * std::cos(7.0 * azimuth) * std::sin(polar);
    file.positions.push_back({radius * std::sin(polar) * std::cos(azimuth),
                              radius * std::sin(polar) * std::sin(azimuth), radius * std::cos(polar)});
    file.colors.push_back(
        {static_cast<std::uint8_t>(40.0 * polar), static_cast<std::uint8_t>(40.0 * azimuth), 7, 255});
  };
  add(0.0, 0.0);
  for (std::uint32_t row = 1; row < rows; ++row)
    for (std::uint32_t i = 0; i < around; ++i) add(pi * row / rows, 2.0 * pi * i / around);
  add(pi, 0.0);
  const auto at = [&](std::uint32_t row, std::uint32_t i) { return 1 + (row - 1) * around + i % around; };
  for (std::uint32_t i = 0; i < around; ++i) {
    file.triangles.push_back({0, at(1, i), at(1, i + 1)});
    for (std::uint32_t row = 1; row + 1 < rows; ++row) {
      file.triangles.push_back({at(row, i), at(row + 1, i), at(row + 1, i + 1)});
      file.triangles.push_back({at(row, i), at(row + 1, i + 1), at(row, i + 1)});
    }
    const auto last = static_cast<std::uint32_t>(file.positions.size() - 1);
    file.triangles.push_back({last, at(rows - 1, i + 1), at(rows - 1, i)});
  }
  return file;
}

facts::BuildOptions options_of(const char* scheme) {
  facts::BuildOptions options;
  options.scheme = scheme;
  options.leaf_triangles = 400;
  return options;
}

struct Built {
  facts::Catalog catalog;
  facts::FinishedNodes hierarchy;
};

Built build_of(const run::Workspace& workspace, const MadeUpFile& file) {
  Built built;
  built.catalog = store_files(workspace, {file}, 5000, 5000);
  fit_lattice(built.catalog, {file});
  auto groups = ingest::request_vertices(workspace, built.catalog);
  ingest::answer_requests(workspace, built.catalog, groups);
  built.hierarchy = scheme_named(workspace.options.scheme).build(workspace, built.catalog, std::move(groups));
  return built;
}

class Hierarchies : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Of, Hierarchies, ::testing::Values(hierarchy::kDiamonds, hierarchy::kBlocks));

void expect_surface(const Built& built, std::size_t triangles) {
  const facts::InputCounts& counts = built.catalog.counts;
  EXPECT_EQ(counts.border_edges, 0U);
  EXPECT_EQ(counts.nonmanifold_edges, 0U);
  EXPECT_EQ(counts.inconsistent_edges, 0U);
  EXPECT_EQ(counts.finest_border_edges, 0U);
  EXPECT_EQ(counts.finest_nonmanifold_edges, 0U);
  EXPECT_GE(built.hierarchy.finest_triangles(), triangles - triangles / 50);
  EXPECT_FALSE(nodes::AreaCheck(built.catalog, built.hierarchy).differs());
}

void expect_levels(const facts::FinishedNodes& hierarchy) {
  ASSERT_GE(hierarchy.levels.size(), 3U);
  std::uint64_t nodes = 0;
  for (const facts::LevelStatistics& level : hierarchy.levels) nodes += level.nodes;
  EXPECT_EQ(nodes, hierarchy.nodes.size());
  EXPECT_EQ(hierarchy.levels[0].nodes, 1U) << "the root's";
  EXPECT_LT(hierarchy.levels[0].triangles, hierarchy.finest_triangles() / 8);
  EXPECT_GT(hierarchy.levels[0].error, hierarchy.levels.back().error);
  for (std::size_t i = 1; i < hierarchy.nodes.size(); ++i)
    EXPECT_LT(std::tie(hierarchy.nodes[i - 1].row.level, hierarchy.nodes[i - 1].row.center),
              std::tie(hierarchy.nodes[i].row.level, hierarchy.nodes[i].row.center));
}

TEST_P(Hierarchies, AreClosedAndShrinkTowardsTheRoot) {
  const MadeUpFile ball = dented_ball(120, 80);
  const CommonFolder folder;
  const TestBuild build(folder, options_of(GetParam()));
  const Built built = build_of(build.workspace(), ball);
  if (!world().is_root()) return;
  expect_surface(built, ball.triangles.size());
  expect_levels(built.hierarchy);
  for (const facts::StoredNode& node : built.hierarchy.nodes) {
    EXPECT_GT(node.row.triangles, 0U);
    EXPECT_EQ(build.workspace().reader.read(node.chunk).size(), node.row.stored_bytes);
  }
}

TEST_P(Hierarchies, AreTheSameWhenTheyAreResumed) {
  const MadeUpFile ball = dented_ball(60, 40);
  const CommonFolder folder;
  std::vector<container::NodeRow> rows;
  for (const bool is_again : {false, true}) {
    const TestBuild build(folder, options_of(GetParam()), is_again);
    const Built built = build_of(build.workspace(), ball);
    if (!world().is_root()) continue;
    std::vector<container::NodeRow> own;
    for (const facts::StoredNode& node : built.hierarchy.nodes) own.push_back(node.row);
    if (is_again) {
      EXPECT_TRUE(own == rows);
    }
    rows = own;
  }
}

TEST_P(Hierarchies, AreAssembledAsTheyAre) {
  const MadeUpFile ball = dented_ball(40, 30);
  const CommonFolder folder;
  facts::BuildOptions options = options_of(GetParam());
  options.tolerance = 1.0;
  options.is_lenient = options.drop_textures = options.keep_outliers = true;
  const TestBuild build(folder, options);
  const Built built = build_of(build.workspace(), ball);
  if (!world().is_root()) return;
  const std::uint64_t bytes = nodes::assemble(build.workspace(), built.catalog, GetParam(), built.hierarchy);
  EXPECT_EQ(bytes, std::filesystem::file_size(folder / "out.h5"));
  const container::ContainerReader reader(folder / "out.h5");
  EXPECT_EQ(reader.metadata().scheme, GetParam());
  EXPECT_TRUE(reader.metadata().has_colors);
  EXPECT_EQ(reader.metadata().inputs.at(0).name, "made-up-0.ply");
  ASSERT_EQ(reader.rows().size(), built.hierarchy.nodes.size());
  for (std::size_t i = 0; i < reader.rows().size(); ++i) {
    EXPECT_EQ(reader.rows()[i].checksum, built.hierarchy.nodes[i].row.checksum);
    EXPECT_TRUE(reader.read_payload(i).ok());
  }
}

TEST_P(Hierarchies, RefuseAToleranceThatCannotBeKept) {
  const MadeUpFile ball = dented_ball(20, 15);
  const CommonFolder folder;
  facts::BuildOptions options = options_of(GetParam());
  options.tolerance = 1e-12;
  const TestBuild build(folder, options);
  const auto error = error_of([&] { build_of(build.workspace(), ball); });
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kUsage);
  EXPECT_NE(std::string(error->what()).find("--tolerance"), std::string::npos);
}

}  // namespace
}  // namespace colossus::pipeline
