#include "reader/diamonds/statue.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "reader/info.hpp"
#include "support/diamonds_fixture.hpp"
#include "verify/diamonds/verify.hpp"

namespace colossus::reader::diamonds {

using namespace support;
namespace {

// The message of the Error(kBadData) that f throws.
template <typename Function>
std::string bad_data(Function f) {
  try {
    f();
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kBadData);
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

void expect_names(const std::string& message, const DiamondsFixture& fixture, const Statue& statue,
                  access::RowIndex row) {
  EXPECT_NE(message.find(fixture.path().string()), std::string::npos) << message;
  EXPECT_NE(message.find(statue.name(row)), std::string::npos) << message;
  // Once, not by each layer that passes it on.
  EXPECT_EQ(message.find(fixture.path().string()), message.rfind(fixture.path().string())) << message;
}

FixtureNode& node_at(DiamondsFixture& fixture, access::RowIndex row) {
  return std::next(fixture.nodes.begin(), row)->second;
}

TEST(Statue, FindsRowsAndLinksHalves) {
  DiamondsFixture fixture(torus(40, 24), 200);
  const auto statue = fixture.open();
  std::size_t links = 0;
  for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
    EXPECT_EQ(statue->find(statue->center(row)), row);
    const auto diamond = hierarchy::Diamond::at(statue->center(row));
    for (std::uint8_t place = 0; place < diamond.place_count; ++place)
      for (int end = 0; end < 2; ++end) {
        const TetrahedronRef child = statue->child({row, place}, end);
        if (!child.exists()) continue;
        ++links;
        const auto half = hierarchy::Diamond::at(statue->center(child.row)).tetrahedra[child.place];
        EXPECT_EQ(half, diamond.tetrahedra[place].child(end));
        EXPECT_EQ(statue->parent(child), (TetrahedronRef{row, place}));
        const auto parents = statue->parents(child.row);
        EXPECT_NE(std::find(parents.begin(), parents.end(), row), parents.end());
      }
  }
  EXPECT_GT(links, 50U);
  EXPECT_EQ(statue->find({8, 8, 8}), access::kNoRow);
  EXPECT_EQ(statue->find({0, 0, 0}), access::kNoRow);
}

TEST(Statue, DecodesWhatWasEncodedAndCachesWithinItsLimit) {
  DiamondsFixture fixture(torus(40, 24), 200);
  const auto statue = fixture.open();
  std::size_t all_bytes = 0;
  for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
    const auto node = statue->node(row);
    EXPECT_EQ(node->mesh, node_at(fixture, row).mesh);
    EXPECT_EQ(statue->node(row), node);
    all_bytes += node->memory_bytes();
  }
  const std::size_t two = statue->node(0)->memory_bytes() + statue->node(1)->memory_bytes();
  EXPECT_LT(two, all_bytes);
  const Statue small(fixture.path(), {two});
  const std::weak_ptr<const Node> first = small.node(0);
  EXPECT_FALSE(first.expired());
  for (access::RowIndex row = 1; row < small.rows().size(); ++row) (void)small.node(row);
  EXPECT_TRUE(first.expired());
  const Statue none(fixture.path(), {0});
  EXPECT_NE(none.node(0), none.node(0));
}

TEST(Statue, NamesTheNodeWhoseCountsAreWrong) {
  DiamondsFixture fixture(sphere(3), 100);
  auto statue = fixture.open();
  FixtureNode& node = node_at(fixture, 3);
  node.row = statue->rows()[3];
  node.keeps_row = true;
  ++node.row.triangles;
  statue = fixture.open();
  expect_names(bad_data([&] { statue->load(3); }), fixture, *statue, 3);
  EXPECT_NO_THROW(statue->load(2));
}

TEST(Statue, RefusesPlacesOutsideTheMask) {
  DiamondsFixture fixture(sphere(3), 100);
  auto statue = fixture.open();
  FixtureNode& node = node_at(fixture, 0);
  node.row = statue->rows()[0];
  node.keeps_row = true;
  const std::uint8_t all = node.row.tetra_mask;
  node.row.tetra_mask = static_cast<std::uint8_t>(all & (all - 1));
  statue = fixture.open();
  expect_names(bad_data([&] { statue->load(0); }), fixture, *statue, 0);
}

TEST(Statue, RefusesMasksOutsideTheRootCube) {
  DiamondsFixture fixture(sphere(3), 100);
  auto statue = fixture.open();
  const access::RowIndex row = 1;  // level 1: a face of the root cube, with two of four places inside
  ASSERT_EQ(statue->rows()[row].level, 1U);
  FixtureNode& node = node_at(fixture, row);
  node.row = statue->rows()[row];
  node.keeps_row = true;
  const auto diamond = hierarchy::Diamond::at(statue->center(row));
  for (std::size_t place = 0; place < 4; ++place)
    if (!diamond.is_inside[place])
      node.row.tetra_mask = static_cast<std::uint8_t>(node.row.tetra_mask | 1U << place);
  fixture.write();
  expect_names(bad_data([&] { Statue damaged(fixture.path()); }), fixture, *statue, row);
}

TEST(Statue, RefusesOtherPositionBitsAndAttributes) {
  DiamondsFixture fixture(sphere(3), 100);
  node_at(fixture, 2).mesh.position_bits = 13;
  // The decoded weights then no longer sum up: they have to be made to.
  for (auto& part : node_at(fixture, 2).mesh.parts)
    for (auto& weights : part.positions)
      for (auto& weight : weights) weight *= 2;
  auto statue = fixture.open();
  expect_names(bad_data([&] { statue->load(2); }), fixture, *statue, 2);
  fixture.metadata.has_colors = false;
  statue = fixture.open();
  expect_names(bad_data([&] { statue->load(1); }), fixture, *statue, 1);
}

TEST(Statue, RefusesACentreOfAnotherLevel) {
  DiamondsFixture fixture(sphere(3), 100);
  auto moved = fixture.nodes.extract(std::prev(fixture.nodes.end()));
  moved.key().first += 1;
  fixture.nodes.insert(std::move(moved));
  const std::string message = bad_data([&] { fixture.open(); });
  EXPECT_NE(message.find("level"), std::string::npos) << message;
}

// Rows that contradict each other, and payloads changed at random under right checksums: everything ends in a
// result or in an Error that says so, and verify() has findings whenever extracting fails.
TEST(Statue, IsTotalOnNonsense) {
  const unsigned seed = 20261124;
  std::cout << "seed " << seed << "\n";
  std::mt19937 random(seed);
  const DiamondsFixture sound(torus(30, 16), 100);
  DiamondsFixture fixture(sphere(0), 1000);
  fixture.metadata = sound.metadata;
  int refused = 0;
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    fixture.nodes = sound.nodes;
    if (round % 2 == 0)
      for (int i = 0; i < 5; ++i) {
        const auto node =
            std::next(fixture.nodes.begin(), static_cast<std::ptrdiff_t>(random() % fixture.nodes.size()));
        const auto what = random() % 4;
        if (what == 0) fixture.nodes.erase(node);
        if (what == 1) node->second.row.flags ^= container::kNodeIsLeaf;
        if (what == 2) node->second.row.error *= static_cast<double>(random() % 10);
        if (what == 3 && node->second.mesh.parts.size() > 1) node->second.mesh.parts.pop_back();
      }
    else
      fixture.change_payload = [&](core::Bytes& payload) {
        // Mostly in the header and the first weights; sometimes cut short.
        if (random() % 4 == 0) payload[random() % 64] = static_cast<std::byte>(random());
        if (random() % 16 == 0) payload[random() % payload.size()] = static_cast<std::byte>(random());
        if (random() % 16 == 0) payload.resize(random() % payload.size());
        if (payload.size() < sizeof(std::uint64_t)) return;
        const auto content = std::span(payload).first(payload.size() - sizeof(std::uint64_t));
        const std::uint64_t checksum = core::hash64(content);
        std::memcpy(payload.data() + content.size(), &checksum, sizeof checksum);
      };
    const auto statue = fixture.open();
    fixture.change_payload = {};
    const verify::measure::VerifyReport report = verify::diamonds::verify(*statue);
    EXPECT_FALSE(report.is_ok());
    EXPECT_NE(info_text(*statue), "");
    try {
      (void)assemble(*statue, cut_at_level(*statue, static_cast<std::uint32_t>(random() % 12)));
      (void)assemble(*statue,
                     cut_with_error(*statue, statue->rows()[random() % statue->rows().size()].error));
      (void)assemble(*statue, cut_with_triangles(*statue, random() % 5000));
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), core::Status::kBadData) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace colossus::reader::diamonds
