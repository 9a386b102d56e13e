// What a statue of any scheme promises of a file that nobody may trust.
#include "reader/access/statue.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "codec/node_codec.hpp"
#include "container/edits.hpp"
#include "core/error.hpp"
#include "reader/open.hpp"
#include "support/blocks_fixture.hpp"

namespace colossus::reader::access {

using namespace support;
namespace {

namespace edits = container::test;

// The message with which the file is refused; empty when it is not.
std::string refusal_of(const std::filesystem::path& path) {
  try {
    open(path);
    return "";
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kBadData);
    EXPECT_EQ(std::string(error.what()).find(path.string()), 0U) << "names the file: " << error.what();
    return error.what();
  }
}

template <typename T>
std::string refusal_of_row(std::size_t row, std::size_t at, T value) {
  BlocksFixture fixture(torus(128, 40));
  fixture.write();
  edits::edit_row(fixture.path(), row, at, value);
  return refusal_of(fixture.path());
}

TEST(AnyStatue, RefusesErrorsAndBoundsThatAreNone) {
  for (const double error : {-1.0, std::nan(""), HUGE_VAL}) {
    const std::string message = refusal_of_row(2, edits::kErrorAt, error);
    EXPECT_NE(message.find("row 2: expected an error of 0 or more"), std::string::npos) << error << message;
  }
  for (std::size_t bound = 0; bound < 6; ++bound)
    // The last two: the least above the greatest.
    for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL, bound < 3 ? 1e30 : -1e30}) {
      const std::string message = refusal_of_row(2, edits::kBoundsAt + 8 * bound, value);
      EXPECT_NE(message.find("row 2: expected finite bounds"), std::string::npos)
          << bound << " " << value << message;
    }
}

TEST(AnyStatue, RefusesRowsThatAreOutOfOrder) {
  BlocksFixture fixture(torus(128, 40));
  const auto rows = fixture.open()->rows();
  for (std::size_t row = 1; row < 12; ++row) {
    fixture.write();
    edits::edit_row(fixture.path(), row, edits::kLevelAt, rows[row - 1].level);
    edits::edit_row(fixture.path(), row, edits::kCenterAt, rows[row - 1].center);
    EXPECT_NE(refusal_of(fixture.path()).find("expected rows ordered by level and centre, none twice"),
              std::string::npos)
        << row;
  }
}

TEST(AnyStatue, FindsRowsByLevelAndCentre) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  RowIndex next = 0;
  for (std::uint32_t level = 0; level <= statue->deepest_level(); ++level) {
    const RowRange range = statue->rows_of_level(level);
    EXPECT_EQ(range.first, next);
    next = range.last;
    for (RowIndex row = range.first; row < range.last; ++row) {
      const auto& center = statue->rows()[row].center;
      EXPECT_EQ(statue->rows()[row].level, level);
      EXPECT_EQ(statue->find_row(level, {center[0], center[1], center[2]}), row);
      EXPECT_EQ(statue->find_row(level, {center[0] + 1, center[1], center[2]}), kNoRow);
      EXPECT_EQ(statue->find_row(level + 1, {center[0], center[1], center[2]}), kNoRow);
    }
  }
  EXPECT_EQ(next, statue->rows().size());
}

TEST(AnyStatue, RefusesNodesOfOtherCountsOrAttributes) {
  const auto message_of = [](auto change) -> std::string {
    BlocksFixture fixture(torus(128, 40));
    FixtureCube& last = fixture.nodes.rbegin()->second;
    const container::NodeRow row = fixture.open()->rows().back();
    change(fixture.metadata, last, row);
    const auto statue = fixture.open();
    try {
      statue->load(static_cast<RowIndex>(statue->rows().size() - 1));
      return "";
    } catch (const core::Error& error) {
      EXPECT_NE(std::string(error.what()).find(name_of(statue->rows().back())), std::string::npos);
      return error.what();
    }
  };
  using Metadata = container::Metadata;
  using Row = container::NodeRow;
  EXPECT_EQ(message_of([](Metadata&, FixtureCube&, const Row&) {}), "");
  EXPECT_NE(message_of([](Metadata& m, FixtureCube&, const Row&) {
              m.has_normals = !m.has_normals;
            }).find("attributes are not those"),
            std::string::npos);
  // More than there are: fewer are refused before anything is decoded.
  EXPECT_NE(message_of([](Metadata&, FixtureCube& cube, const Row& row) {
              cube.row = row;
              cube.keeps_row = true;
              ++cube.row.triangles;
            }).find("its row says"),
            std::string::npos);
}

}  // namespace
}  // namespace colossus::reader::access
