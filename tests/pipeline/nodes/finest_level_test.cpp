#include "pipeline/nodes/finest_level.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace colossus::pipeline::nodes {
namespace {

// An input of area 1000 on a lattice of step 0.5, and leaves with so much of it on one of step 0.25.
facts::Catalog input() {
  facts::Catalog catalog;
  catalog.files.push_back({"a.ply", 0, "", false, false});
  catalog.area = 1000.0;
  catalog.lattice.step = 0.5;
  return catalog;
}

facts::FinishedNodes leaves(double share, std::uint32_t triangles, int position_bits = 12) {
  facts::FinishedNodes hierarchy;
  hierarchy.lattice.step = 0.25;
  hierarchy.position_bits = position_bits;
  facts::FinishedNode node;
  node.area = share * 4000.0;
  node.row.triangles = triangles;
  node.row.flags = container::kNodeIsLeaf;
  hierarchy.add(node);
  return hierarchy;
}

TEST(AreaCheck, ComparesOnOneLattice) {
  const AreaCheck check(input(), leaves(0.75, 1));
  EXPECT_DOUBLE_EQ(check.input, 4000.0);
  EXPECT_DOUBLE_EQ(check.finest, 3000.0);
}

TEST(AreaCheck, DiffersByMoreThanAThousandthAtTwelveBits) {
  for (const double share : {0.9991, 1.0, 1.0009})
    EXPECT_FALSE(AreaCheck(input(), leaves(share, 1)).differs());
  for (const double share : {0.5, 0.9989, 1.0011}) {
    EXPECT_TRUE(AreaCheck(input(), leaves(share, 1)).differs());
    EXPECT_FALSE(AreaCheck(input(), leaves(share, 1, 11)).differs()) << "fewer bits are rough";
  }
}

TEST(LostSurface, IsRefusedBelowHalf) {
  EXPECT_NO_THROW(refuse_lost_surface(input(), leaves(0.51, 1)));
  for (const auto& [share, triangles] : {std::pair{0.49, 10U}, {1.0, 0U}}) {
    try {
      refuse_lost_surface(input(), leaves(share, triangles));
      ADD_FAILURE() << share;
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), core::Status::kBadData);
      EXPECT_EQ(std::string(error.what())
                    .find(fmt::format(
                        "a.ply: the finest level would have {} triangles and {:.2f} % of the input's area",
                        triangles, 100.0 * share)),
                0U)
          << error.what();
    }
  }
}

TEST(FinestLevel, CompletesTheCounts) {
  for (const double share : {1.0, 0.9}) {
    facts::FinishedNodes finished = leaves(share, 7);
    facts::FinishedNode node;
    node.row.level = 2;
    node.row.triangles = 5;
    node.row.flags = container::kNodeIsLeaf | container::kNodeIsAboveLimit;
    finished.add(node);
    node.row.level = 3;
    finished.add(node);
    node.row.flags = 0;  // not of the finest level
    finished.add(node);
    facts::Catalog catalog = input();
    catalog.counts.leaves_above_limit = 100;  // of an earlier call
    catalog.counts.area_differs = 1;
    catalog.counts.triangles = 77;
    for (int call = 0; call < 2; ++call) {
      count_finest_level(catalog, finished);
      EXPECT_EQ(catalog.counts.finest_triangles, 17U);
      EXPECT_EQ(catalog.counts.leaves_above_limit, 2U);
      EXPECT_EQ(catalog.counts.area_differs, share == 1.0 ? 0U : 1U);
      EXPECT_EQ(catalog.counts.triangles, 77U);
    }
  }
}

TEST(FinestLevel, IsComparedInTheLog) {
  facts::Catalog catalog = input();
  catalog.counts.finest_border_edges = 12;
  catalog.counts.finest_nonmanifold_edges = 34;
  ::testing::internal::CaptureStdout();
  log_finest_level(catalog, leaves(0.9995, 7));
  const std::string said = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(said.find("7 triangles, 99.9500 % of the input's area; 12 border and 34 non-manifold edges"),
            std::string::npos)
      << said;
}

TEST(FinestLevel, IsWarnedOfWhereItDiffers) {
  const auto said = [](double share) {
    ::testing::internal::CaptureStderr();
    log_finest_level(input(), leaves(share, 1));
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said(1.0), "");
  EXPECT_NE(said(0.9).find("90.000 %"), std::string::npos);
}

}  // namespace
}  // namespace colossus::pipeline::nodes
