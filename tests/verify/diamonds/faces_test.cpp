#include "verify/diamonds/faces.hpp"

#include <gtest/gtest.h>

#include "support/diamonds_fixture.hpp"

namespace colossus::verify::diamonds {

using namespace support;
namespace {

std::vector<FaceEntry> face_entries(const reader::diamonds::Statue& statue) {
  std::vector<FaceEntry> entries;
  for (reader::access::RowIndex row = 0; row < statue.rows().size(); ++row) {
    const reader::diamonds::Node node = statue.load(row);
    std::array<BoundaryChains, reader::diamonds::kMaxPlaces> chains;
    std::array<const BoundaryChains*, reader::diamonds::kMaxPlaces> present{};
    for (const auto& part : node.mesh.parts) {
      chains[part.place] = boundary_chains(part, node.diamond.tetrahedra[part.place]);
      present[part.place] = &chains[part.place];
    }
    const NodeBoundary boundary = node_boundary(statue, row, node.diamond, present, false);
    entries.insert(entries.end(), boundary.faces.begin(), boundary.faces.end());
  }
  return entries;
}

TEST(Faces, AFaceThatTheSurfaceCrossesNeedsBothSides) {
  DiamondsFixture fixture(sphere(3), 100);
  const auto statue = fixture.open();
  std::vector<FaceEntry> entries = face_entries(*statue);
  EXPECT_EQ(check_faces(*statue, entries, 5).mismatches, 0U);
  const auto crossed = std::find_if(entries.begin(), entries.end(),
                                    [](const FaceEntry& entry) { return entry.polyline != core::Hash128{}; });
  ASSERT_NE(crossed, entries.end());
  const FaceEntry chosen = *crossed;
  std::erase_if(entries, [&](const FaceEntry& e) { return e.face == chosen.face && e.side != chosen.side; });
  const BoundaryReport report = check_faces(*statue, entries, 5);
  EXPECT_EQ(report.mismatches, 1U);
  ASSERT_EQ(report.examples.size(), 1U);
  EXPECT_NE(report.examples[0].find("nothing on its other side"), std::string::npos) << report.examples[0];
}

TEST(Faces, ChainsAlongAnEdgeMustAddUpToNothing) {
  DiamondsFixture fixture(sphere(3), 100);
  const auto statue = fixture.open();
  const auto leaf = static_cast<reader::access::RowIndex>(statue->rows().size() - 1);
  ASSERT_TRUE(statue->is_leaf(leaf));
  const auto place = static_cast<std::uint8_t>(std::countr_zero(statue->rows()[leaf].tetra_mask));
  const auto corners = hierarchy::Diamond::at(statue->center(leaf)).tetrahedra[place].corners;
  std::vector<EdgeEntry> entries{{{leaf, place}, {{corners[0], corners[1]}, {{{1, 2, 3}, {4, 5, 6}}}}}};
  const BoundaryReport report = check_edges(*statue, entries, 5);
  EXPECT_EQ(report.mismatches, 1U);
  ASSERT_EQ(report.examples.size(), 1U);
  EXPECT_NE(report.examples[0].find("leave 1 edges open"), std::string::npos) << report.examples[0];
}

TEST(Faces, NormalizedChainsHaveNoOppositePairsAndNoPoints) {
  const codec::coded::ScaledPosition a{1, 2, 3};
  const codec::coded::ScaledPosition b{1, 2, 4};
  const codec::coded::ScaledPosition c{0, 9, 9};
  EXPECT_EQ(normalized({{a, b}, {b, a}, {b, c}, {a, a}}), (Chain{{b, c}}));
  EXPECT_EQ(normalized({{a, b}, {a, b}, {b, a}}), (Chain{{a, b}}));
  EXPECT_EQ(normalized({{b, c}, {a, b}}), (Chain{{a, b}, {b, c}}));
}

// Two vertices on the face opposite corner 0, and one that is off all faces.
TEST(Faces, AChainHasTheEdgesWhoseEndsAreOnTheFace) {
  const auto tetrahedron = hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[0];
  codec::coded::CodedPart part;
  part.positions = {{0, 100, 100, 56}, {0, 50, 100, 106}, {10, 100, 90, 56}};
  part.triangles = {{0, 1, 2}};
  const BoundaryChains chains = boundary_chains(part, tetrahedron);
  EXPECT_EQ(chains.faces[0], (Chain{{codec::coded::scaled_position(part.positions[0], tetrahedron),
                                     codec::coded::scaled_position(part.positions[1], tetrahedron)}}));
  for (const std::size_t other : {1U, 2U, 3U}) EXPECT_TRUE(chains.faces[other].empty());
  EXPECT_TRUE(chains.edges.empty());
}

}  // namespace
}  // namespace colossus::verify::diamonds
