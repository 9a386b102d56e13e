#include "reader/info.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/diamonds_fixture.hpp"

namespace colossus::reader {

using namespace support;
namespace {

TEST(Info, JsonHoldsTheMetadataAndSumsPerLevel) {
  DiamondsFixture fixture(torus(40, 24), 200);
  fixture.nodes.rbegin()->second.row.flags |= container::kNodeIsAboveLimit;
  const auto statue = fixture.open();
  const auto json = nlohmann::json::parse(info_json(*statue));
  EXPECT_EQ(json["scheme"], "diamonds");
  EXPECT_EQ(json["producer"]["name"], "colossus");
  EXPECT_EQ(json["producer"]["version"], core::release_version());
  EXPECT_EQ(json["position_bits"], 12);
  EXPECT_EQ(json["counts"]["triangles"], 1920);
  EXPECT_EQ(json["options"]["leaf-triangles"], "200");
  EXPECT_EQ(json["inputs"][0]["name"], "generated.ply");
  EXPECT_EQ(json["nodes"], statue->rows().size());
  EXPECT_EQ(json["above_limit"], 1);
  std::uint64_t triangles = 0;
  std::uint64_t leaves = 0;
  for (const auto& level : json["levels"]) {
    triangles += level["triangles"].get<std::uint64_t>();
    leaves += level["leaves"].get<std::uint64_t>();
    EXPECT_EQ(level["statistics"]["target"], 77);
    EXPECT_EQ(level["statistics"]["locked"], 0.25);
    EXPECT_NEAR(level["bits_per_vertex"].get<double>(),
                8.0 * level["bytes"].get<double>() / level["vertices"].get<double>(), 1e-9);
  }
  std::uint64_t expected = 0;
  std::uint64_t expected_leaves = 0;
  for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
    expected += statue->rows()[row].triangles;
    expected_leaves += statue->is_leaf(row) ? 1 : 0;
  }
  EXPECT_EQ(triangles, expected);
  EXPECT_EQ(leaves, expected_leaves);
}

TEST(Info, TextHasALinePerLevelAndAllStoredColumns) {
  DiamondsFixture fixture(torus(40, 24), 200);
  const auto statue = fixture.open();
  const std::string text = info_text(*statue);
  for (const char* word : {"bits/vertex", "target", "locked", "generated.ply", "border_edges", "lattice",
                           "diamonds", "producer"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
  const std::string table = text.substr(text.rfind("\n\n") + 2);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), statue->deepest_level() + 2);
}

TEST(Info, SaysWhatTheBitsAreSpentOn) {
  DiamondsFixture fixture(torus(40, 24), 200);
  // Of each level so many bytes on positions, and nothing known of the rest.
  const std::size_t levels = fixture.nodes.rbegin()->first.first + 1;
  fixture.metadata.levels.push_back({"position_bytes", std::vector<std::uint64_t>(levels, 1000)});
  const auto statue = fixture.open();
  const auto json = nlohmann::json::parse(info_json(*statue));
  for (const auto& level : json["levels"]) {
    EXPECT_EQ(level["part_bits_per_vertex"].size(), 1U);
    EXPECT_NEAR(level["part_bits_per_vertex"]["positions"].get<double>(),
                8000.0 / level["vertices"].get<double>(), 1e-9);
  }
  EXPECT_NE(info_text(*statue).find("topology  position  normal  colour  parent"), std::string::npos);
}

// The finest vertices are as near to the input's as info says.
TEST(Info, QuantisationErrorIsABound) {
  const WorldMesh input = torus(40, 24);
  DiamondsFixture fixture(input, 200, 8);
  const auto statue = fixture.open();
  const auto json = nlohmann::json::parse(info_json(*statue));
  const double bound = json["quantisation_error"].get<double>() + json["lattice_error"].get<double>();
  const access::CutMesh finest = assemble(*statue, cut_at_level(*statue, 99));
  double greatest = 0.0;
  for (const verify::measure::WorldPoint& p : input.points) {
    double nearest = 1e300;
    for (const verify::measure::WorldPoint& q : finest.positions)
      nearest = std::min(nearest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
    greatest = std::max(greatest, nearest);
  }
  EXPECT_LE(greatest, bound);
  EXPECT_GT(greatest, bound / 20.0);
}

}  // namespace
}  // namespace colossus::reader
