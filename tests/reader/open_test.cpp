#include "reader/open.hpp"

#include <gtest/gtest.h>

#include "reader/blocks/extract.hpp"
#include "reader/diamonds/extract.hpp"
#include "support/blocks_fixture.hpp"

namespace colossus::reader {

using namespace support;
namespace {

TEST(Open, RefusesAnUnknownScheme) {
  DiamondsFixture fixture(torus(20, 12), 100);
  fixture.metadata.scheme = "diamants";
  fixture.write();
  try {
    open(fixture.path());
    FAIL();
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kBadData);
    for (const char* word : {"scheme", "'diamonds' or 'blocks'", "'diamants'"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST(Open, GivesAStatueThatExtractsWhatItsSchemeDoes) {
  DiamondsFixture diamonds(torus(20, 12), 100);
  const auto of_diamonds = diamonds.open();
  const access::Extraction tetrahedra = open(diamonds.path())->extract(access::AtLevel{2});
  EXPECT_EQ(tetrahedra.mesh.positions,
            diamonds::assemble(*of_diamonds, diamonds::cut_at_level(*of_diamonds, 2)).positions);
  EXPECT_EQ(open(diamonds.path())->name_of_parts(), "tetrahedra");
  BlocksFixture blocks(torus(40, 24));
  const auto of_blocks = blocks.open();
  const access::Eye eye{{0, 0, 9}, {}};
  const access::Extraction cubes = open(blocks.path())->extract(eye);
  EXPECT_EQ(cubes.mesh.positions,
            blocks::assemble(*of_blocks, blocks::cut_at_eye(*of_blocks, eye)).positions);
  EXPECT_EQ(cubes.parts_by_level, blocks::parts_by_level(*of_blocks, blocks::cut_at_eye(*of_blocks, eye)));
}

}  // namespace
}  // namespace colossus::reader
