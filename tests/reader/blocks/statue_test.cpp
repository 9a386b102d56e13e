#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "reader/info.hpp"
#include "reader/open.hpp"
#include "support/blocks_fixture.hpp"

namespace colossus::reader::blocks {

using namespace support;
namespace {

using hierarchy::CubeId;

TEST(BlocksStatue, FindsAndLoadsEveryCube) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  ASSERT_EQ(statue->rows().size(), fixture.nodes.size());
  access::RowIndex row = 0;
  for (const auto& [cube, node] : fixture.nodes) {
    EXPECT_EQ(statue->cube(row), cube);
    EXPECT_EQ(statue->find(cube), row);
    EXPECT_EQ(statue->load(row), node.mesh);
    EXPECT_EQ(*statue->node(row), node.mesh);
    EXPECT_EQ(statue->node(row), statue->node(row));
    if (cube.level > 0) {
      EXPECT_EQ(statue->cube(statue->parent(row)), cube.parent());
      const auto siblings = statue->children(statue->parent(row));
      EXPECT_EQ(siblings[static_cast<std::size_t>((cube.x & 1) + 2 * (cube.y & 1) + 4 * (cube.z & 1))], row);
    }
    ++row;
  }
  EXPECT_EQ(statue->find({3, 9, 0, 0}), access::kNoRow);
  EXPECT_EQ(statue->find({9, 0, 0, 0}), access::kNoRow);
  EXPECT_EQ(statue->parent(0), access::kNoRow);
  EXPECT_EQ(statue->rows_of_level(0).size(), 1U);
  EXPECT_EQ(statue->rows_of_level(4).size(), 0U);
}

TEST(BlocksStatue, RefusesWhatTheSchemeNeeds) {
  const auto fails = [](auto change) {
    BlocksFixture fixture(torus(128, 40));
    change(fixture);
    try {
      fixture.open();
    } catch (const core::Error& error) {
      return error.status() == core::Status::kBadData;
    }
    return false;
  };
  EXPECT_TRUE(fails([](BlocksFixture& f) { f.metadata.parameters.clear(); }));
  EXPECT_TRUE(fails([](BlocksFixture& f) { f.metadata.parameters.pop_back(); }));
  for (const double sigma0 : {0.0, -0.1, 1.5})
    EXPECT_TRUE(fails([&](BlocksFixture& f) { f.metadata.parameters[0].value = sigma0; })) << sigma0;
  for (const double size : {0.0, 3.0, 5.0, 4.5, 68.0})
    EXPECT_TRUE(fails([&](BlocksFixture& f) { f.metadata.parameters[1].value = size; })) << size;
  EXPECT_FALSE(fails([](BlocksFixture&) {}));
  // Rows that are no cubes of the scheme.
  const auto last = [](BlocksFixture& f) -> container::NodeRow& {
    FixtureCube& cube = f.nodes.rbegin()->second;
    cube.row = f.open()->rows().back();
    cube.keeps_row = true;
    return cube.row;
  };
  EXPECT_FALSE(fails([&](BlocksFixture& f) { last(f); }));
  EXPECT_TRUE(fails([&](BlocksFixture& f) { last(f).tetra_mask = 3; }));
  // The deepest cubes would have sides that these bits do not reach.
  EXPECT_TRUE(fails([&](BlocksFixture& f) { ++f.metadata.position_bits; }));
}

TEST(BlocksStatue, RefusesNodesThatAreNotWhatTheContainerSays) {
  const auto fails = [](auto change) {
    BlocksFixture fixture(torus(128, 40));
    change(fixture.nodes.rbegin()->second.mesh);
    const auto statue = fixture.open();
    EXPECT_THROW(statue->load(static_cast<access::RowIndex>(statue->rows().size() - 1)), core::Error);
    EXPECT_NO_THROW(statue->load(0));
  };
  fails([](codec::coded::CodedNode& m) { move_vertex(m, 0, {-1, 0, 0}); });
  fails([](codec::coded::CodedNode& m) { move_vertex(m, 0, {0, 0, 8193}); });
  fails([](codec::coded::CodedNode& m) {
    m.has_normals = false;
    m.parts[0].normals.clear();
  });
  fails([](codec::coded::CodedNode& m) {
    m.has_parents = false;
    m.parts[0].parents.clear();
  });
}

TEST(BlocksStatue, OpenLooksAtTheScheme) {
  BlocksFixture blocks(torus(128, 40));
  blocks.write();
  EXPECT_NE(dynamic_cast<Statue*>(open(blocks.path()).get()), nullptr);
  EXPECT_THROW(diamonds::Statue(blocks.path()), core::Error);
  DiamondsFixture diamonds(sphere(3), 100);
  diamonds.write();
  EXPECT_NE(dynamic_cast<diamonds::Statue*>(open(diamonds.path()).get()), nullptr);
  EXPECT_THROW(Statue(diamonds.path()), core::Error);
}

TEST(BlocksStatue, InfoTellsSchemeParametersAndLevels) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  const auto json = nlohmann::json::parse(info_json(*statue));
  EXPECT_EQ(json["scheme"], "blocks");
  EXPECT_EQ(json["parameters"]["sigma0"], 0.25);
  EXPECT_EQ(json["parameters"]["block_size"], 4.0);
  EXPECT_EQ(json["levels"].size(), 4U);
  EXPECT_EQ(json["levels"][3]["triangles"], 128 * 40 * 2);
  const std::string text = info_text(*statue);
  for (const char* word : {"blocks", "sigma0 = 0.25", "bits per side"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
}

}  // namespace
}  // namespace colossus::reader::blocks
