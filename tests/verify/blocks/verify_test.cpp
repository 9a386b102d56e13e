#include "verify/blocks/verify.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "reader/blocks/extract.hpp"
#include "support/blocks_fixture.hpp"
#include "verify/blocks/clefts.hpp"

namespace colossus::verify::blocks {

using namespace support;
namespace {

using hierarchy::CubeId;

measure::VerifyReport verified(BlocksFixture& fixture, const measure::VerifyOptions& options = {}) {
  return verify(*fixture.open(), options);
}

// A cube of the level with the most triangles, so that all of its surroundings are there.
FixtureCube& large_cube(BlocksFixture& fixture, int level) {
  FixtureCube* largest = nullptr;
  for (auto& [cube, node] : fixture.nodes)
    if (cube.level == level &&
        (!largest || node.mesh.parts[0].triangles.size() > largest->mesh.parts[0].triangles.size()))
      largest = &node;
  return *largest;
}

// A vertex of the level that two cubes have, in both of them.
struct SharedPlace {
  std::array<codec::coded::CodedNode*, 2> meshes{};
  std::array<std::size_t, 2> vertices{};
};
SharedPlace shared_place(BlocksFixture& fixture, int level) {
  std::map<geometry::Point, std::pair<codec::coded::CodedNode*, std::size_t>> seen;
  for (auto& [cube, node] : fixture.nodes) {
    if (cube.level != level) continue;
    for (std::size_t i = 0; i < node.mesh.parts[0].positions.size(); ++i) {
      const auto [found, is_new] = seen.try_emplace(lattice_position(node.mesh, i), &node.mesh, i);
      if (!is_new) return {{found->second.first, &node.mesh}, {found->second.second, i}};
    }
  }
  return {};
}

// Expects findings of this kind, and of no other.
void expect_only(const measure::VerifyReport& report, measure::FindingKind kind) {
  EXPECT_GE(report.count(kind), 1U) << to_text(report);
  EXPECT_EQ(report.count(kind), report.total()) << to_text(report);
}

TEST(BlocksVerify, FindsNothingInASoundContainer) {
  BlocksFixture fixture(torus(128, 40));
  const measure::VerifyReport report = verified(fixture);
  EXPECT_TRUE(report.is_ok()) << to_text(report);
  EXPECT_EQ(report.nodes, fixture.nodes.size());
  std::uint64_t parents = 0;
  std::uint64_t triangles = 0;
  for (const auto& [cube, node] : fixture.nodes)
    if (cube.level > 0) {
      parents += node.mesh.parts[0].positions.size();
      triangles += node.mesh.parts[0].triangles.size();
    }
  EXPECT_EQ(report.parents, parents);
  EXPECT_EQ(report.mapped_triangles, triangles);
  ASSERT_EQ(report.levels.size(), 4U);
}

TEST(BlocksVerify, LevelsAreCountedAsExtracted) {
  BlocksFixture fixture(torus(128, 40));
  fixture.metadata.counts.clear();
  // Holes at every level, and the same triangle twice and once reversed.
  for (auto& [cube, node] : fixture.nodes)
    if (node.mesh.parts[0].triangles.size() > 4) {
      auto& triangles = node.mesh.parts[0].triangles;
      triangles.pop_back();
      triangles.push_back(triangles.front());
      triangles.push_back({triangles[1][1], triangles[1][0], triangles[1][2]});
    }
  const auto statue = fixture.open();
  const measure::VerifyReport report = verify(*statue);
  for (const measure::LevelReport& level : report.levels) {
    const reader::access::CutMesh mesh = assemble(*statue, cut_at_level(*statue, level.level));
    const Census census = census_of(mesh);
    EXPECT_GT(census.border_edges, 0U);
    EXPECT_EQ(level.border_edges, census.border_edges) << level.level;
    EXPECT_EQ(level.nonmanifold_edges, census.nonmanifold_edges) << level.level;
    EXPECT_EQ(level.triangles, mesh.triangles.size()) << level.level;
  }
}

TEST(BlocksVerify, FindsAParentOutOfRange) {
  BlocksFixture fixture(torus(128, 40));
  large_cube(fixture, 2).mesh.parts[0].parents[3] = 1U << 20;
  const measure::VerifyReport report = verified(fixture);
  expect_only(report, measure::FindingKind::kParent);
  EXPECT_EQ(report.total(), 1U);
}

TEST(BlocksVerify, FindsAWrongParentByTheMapAndItsNeighbours) {
  BlocksFixture fixture(torus(128, 40));
  const SharedPlace place = shared_place(fixture, 2);
  auto& parent = place.meshes[0]->parts[0].parents[place.vertices[0]];
  parent = parent == 0 ? 1 : 0;
  const measure::VerifyReport report = verified(fixture);
  EXPECT_GE(report.count(measure::FindingKind::kShared), 1U) << to_text(report);
  EXPECT_NE(to_text(report).find("the parent of the vertex"), std::string::npos) << to_text(report);
}

TEST(BlocksVerify, FindsAParentThatIsTooFar) {
  BlocksFixture fixture(torus(128, 40));
  // The farthest parent in the same cube, in both copies of the container.
  codec::coded::CodedPart& mesh = large_cube(fixture, 3).mesh.parts[0];
  mesh.parents[0] = *std::max_element(mesh.parents.begin(), mesh.parents.end());
  const measure::VerifyReport report = verified(fixture);
  EXPECT_EQ(report.count(measure::FindingKind::kCondition), 1U) << to_text(report);
  EXPECT_EQ(report.count(measure::FindingKind::kMap), 1U) << to_text(report);
}

TEST(BlocksVerify, ComparesLengthsWithSigma0Exactly) {
  // The longest edges and ways of the fixture, as sigma0 that they just keep.
  BlocksFixture fixture(torus(128, 40));
  double least = 0.0;
  for (const auto& [cube, node] : fixture.nodes) {
    for (const mesh::Triangle& t : node.mesh.parts[0].triangles)
      for (std::size_t k = 0; k < 3; ++k)
        least = std::max(
            least,
            std::ldexp(static_cast<double>(hierarchy::max_distance(
                           lattice_position(node.mesh, t[k]), lattice_position(node.mesh, t[(k + 1) % 3]))),
                       cube.level - 13));
    for (std::size_t i = 0; i < node.mesh.parts[0].parents.size(); ++i)
      least = std::max(least, std::ldexp(static_cast<double>(hierarchy::max_distance(
                                             lattice_position(node.mesh, i),
                                             lattice_position(fixture.nodes.at(cube.parent()).mesh,
                                                              node.mesh.parts[0].parents[i]))),
                                         cube.level + 1 - 13));
  }
  fixture.metadata.parameters[0].value = least;
  EXPECT_TRUE(verified(fixture).is_ok());
  fixture.metadata.parameters[0].value = std::nextafter(least, 0.0);
  expect_only(verified(fixture), measure::FindingKind::kCondition);
}

// With one level there are no parents to be near to.
TEST(BlocksVerify, ComparesEdgesWithSigma0Exactly) {
  BlocksFixture fixture(torus(128, 40), 0, 0.25, 13);
  std::int64_t longest = 0;
  const codec::coded::CodedNode& mesh = fixture.nodes.at({}).mesh;
  for (const mesh::Triangle& t : mesh.parts[0].triangles)
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, hierarchy::max_distance(lattice_position(mesh, t[k]),
                                                          lattice_position(mesh, t[(k + 1) % 3])));
  double& sigma0 = fixture.metadata.parameters[0].value;
  sigma0 = std::ldexp(static_cast<double>(longest), -13);
  EXPECT_TRUE(verified(fixture).is_ok());
  sigma0 = std::nextafter(sigma0, 0.0);
  const measure::VerifyReport report = verified(fixture);
  expect_only(report, measure::FindingKind::kCondition);
  EXPECT_EQ(report.total(), 1U);
}

TEST(BlocksVerify, FindsTrianglesThatTheMapDoesNotMake) {
  for (int fault = 0; fault < 4; ++fault) {
    BlocksFixture fixture(torus(128, 40));
    auto& triangles = large_cube(fixture, 1).mesh.parts[0].triangles;
    const mesh::Triangle t = triangles.back();
    if (fault == 0) triangles.pop_back();                   // lacks one
    if (fault == 1) triangles.back() = {t[1], t[0], t[2]};  // reversed
    if (fault == 2) triangles.push_back(t);                 // has one twice
    if (fault == 3) {                                       // has an opposite pair more
      triangles.push_back(t);
      triangles.push_back({t[1], t[0], t[2]});
    }
    const measure::VerifyReport report = verified(fixture);
    // As the parent's image, and as the triangles that make the root's, unless those degenerate.
    EXPECT_GE(report.count(measure::FindingKind::kMap), 1U) << fault << to_text(report);
    EXPECT_EQ(report.count(measure::FindingKind::kBorder), fault == 0 ? 1U : 0U) << fault << to_text(report);
  }
  // The same triangle with another first corner is the same.
  BlocksFixture fixture(torus(128, 40));
  for (auto& t : large_cube(fixture, 1).mesh.parts[0].triangles) t = {t[1], t[2], t[0]};
  EXPECT_EQ(verified(fixture).count(measure::FindingKind::kMap), 0U);
}

TEST(BlocksVerify, FindsAttributesThatCubesDisagreeAbout) {
  for (const bool is_normal : {true, false}) {
    BlocksFixture fixture(torus(128, 40));
    const SharedPlace place = shared_place(fixture, 3);
    if (is_normal)
      place.meshes[1]->parts[0].normals[place.vertices[1]][0] ^= 16;
    else
      place.meshes[1]->parts[0].colors[place.vertices[1]][2] ^= 16;
    const measure::VerifyReport report = verified(fixture);
    expect_only(report, measure::FindingKind::kShared);
    EXPECT_NE(to_text(report).find(is_normal ? "the normal" : "the colour"), std::string::npos);
  }
}

TEST(BlocksVerify, FindsAVertexThatOneCubeMoves) {
  BlocksFixture fixture(torus(128, 40));
  const SharedPlace place = shared_place(fixture, 3);
  geometry::Point moved = lattice_position(*place.meshes[1], place.vertices[1]);
  moved.x += 1;
  move_vertex(*place.meshes[1], place.vertices[1], moved);
  // A crack that no map shows, since the parent is the same.
  EXPECT_GE(verified(fixture).count(measure::FindingKind::kBorder), 1U);
}

TEST(BlocksVerify, FindsBorderAndNonManifoldEdges) {
  BlocksFixture fixture(torus(128, 40));
  fixture.metadata.counts = {{"border_edges", 0}, {"nonmanifold_edges", 0}};
  auto& triangles = large_cube(fixture, 3).mesh.parts[0].triangles;
  triangles.push_back(triangles.front());
  triangles.erase(triangles.begin() + 5);
  const measure::VerifyReport report = verified(fixture);
  EXPECT_GE(report.count(measure::FindingKind::kBorder), 1U) << to_text(report);
  EXPECT_GE(report.count(measure::FindingKind::kNonManifold), 1U) << to_text(report);
}

TEST(BlocksVerify, FindsWrongStructure) {
  const auto report_of = [](auto change) {
    BlocksFixture fixture(torus(128, 40));
    change(fixture);
    return verified(fixture);
  };
  const auto first_of_level = [](BlocksFixture& fixture, int level) {
    return fixture.nodes.lower_bound(CubeId{level, -1, 0, 0});
  };
  for (const int level : {0, 1, 2}) {
    expect_only(report_of([&](BlocksFixture& f) { first_of_level(f, level)->second.row.flags = 1; }),
                measure::FindingKind::kStructure);
    // Its children have no parent cube.
    const measure::VerifyReport missing =
        report_of([&](BlocksFixture& f) { f.nodes.erase(first_of_level(f, level)); });
    EXPECT_GE(missing.count(measure::FindingKind::kStructure), 1U) << to_text(missing);
  }
  expect_only(report_of([&](BlocksFixture& f) { first_of_level(f, 3)->second.row.flags = 0; }),
              measure::FindingKind::kStructure);
  expect_only(report_of([&](BlocksFixture& f) { first_of_level(f, 1)->second.row.error = 0.5; }),
              measure::FindingKind::kErrorGrowth);
  // A cube that is left without children; what its triangles came from is gone too.
  const measure::VerifyReport childless = report_of([&](BlocksFixture& f) {
    const CubeId cube = first_of_level(f, 2)->first;
    for (int octant = 0; octant < 8; ++octant) f.nodes.erase(cube.child(octant));
  });
  EXPECT_GE(childless.count(measure::FindingKind::kStructure), 1U) << to_text(childless);
}

TEST(BlocksVerify, FindsAMissingLeaf) {
  BlocksFixture fixture(torus(128, 40));
  fixture.nodes.erase(std::prev(fixture.nodes.end()));
  const measure::VerifyReport report = verified(fixture);
  EXPECT_GE(report.count(measure::FindingKind::kBorder), 1U) << to_text(report);
}

TEST(BlocksVerify, FindsPositionsOutsideTheBounds) {
  BlocksFixture fixture(torus(128, 40));
  const auto rows = fixture.open()->rows();
  auto node = std::next(fixture.nodes.begin(), 4);
  node->second.row = rows[4];
  node->second.row.bounds[3] = std::nextafter(node->second.row.bounds[3], -1e9);
  node->second.keeps_row = true;
  expect_only(verified(fixture), measure::FindingKind::kBounds);
}

TEST(BlocksVerify, FindsDamageOnceAndBlamesNobodyElse) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  for (const reader::access::RowIndex row :
       {reader::access::RowIndex{0}, reader::access::RowIndex{3},
        static_cast<reader::access::RowIndex>(statue->rows().size() - 1)}) {
    fixture.write();
    {
      std::fstream file(fixture.path(), std::ios::in | std::ios::out | std::ios::binary);
      const auto place = static_cast<std::streamoff>(statue->rows()[row].offset + 20);
      file.seekg(place);
      const int value = file.get();
      file.seekp(place);
      file.put(static_cast<char>(value ^ 4));
    }
    const measure::VerifyReport report = verify(reader::blocks::Statue(fixture.path()));
    EXPECT_EQ(report.count(measure::FindingKind::kDamage), 1U) << to_text(report);
    EXPECT_NE(report.findings[0].message.find(statue->name(row)), std::string::npos) << to_text(report);
    // A hole, of course.
    EXPECT_EQ(report.total(), 1U + report.count(measure::FindingKind::kBorder)) << to_text(report);
  }
}

TEST(BlocksVerify, MeasuresTheErrorsAgainstTheInput) {
  BlocksFixture fixture(torus(128, 40));
  fixture.measure_errors();
  const measure::Surface against = fixture.input.surface();
  measure::VerifyOptions options;
  options.against = &against;
  options.samples_per_node = 500;
  const measure::VerifyReport report = verified(fixture, options);
  EXPECT_TRUE(report.is_ok()) << to_text(report);
  EXPECT_GT(report.measured_nodes, 10U);
  EXPECT_GT(report.greatest_ratio, 0.5);
  EXPECT_LE(report.greatest_ratio, 1.0);

  for (auto& [cube, node] : fixture.nodes) node.row.error *= 20.0;
  expect_only(verified(fixture, options), measure::FindingKind::kLooseError);
  for (auto& [cube, node] : fixture.nodes) node.row.error *= 0.01;
  EXPECT_GT(verified(fixture, options).count(measure::FindingKind::kDistance), fixture.nodes.size() / 3);
}

// Where one small triangle is counted, among 20 in the interior; the lattice has 13 bits, blocks are 4 cubes.
std::optional<CleftCounts::Zone> zone_at(const reader::blocks::Statue& statue, int level, std::int32_t x,
                                         std::int32_t y, std::int32_t z, bool has_shifted_blocks = true) {
  codec::coded::CodedNode mesh = codec::coded::lattice_node();
  set_lattice_positions(mesh, std::array<geometry::Point, 6>{{{x - 1, y - 1, z},
                                                              {x + 1, y, z - 1},
                                                              {x, y + 1, z + 1},
                                                              {999, 999, 1000},
                                                              {1001, 1000, 999},
                                                              {1000, 1001, 1001}}});
  mesh.parts[0].triangles.assign(20, {3, 4, 5});
  mesh.parts[0].triangles.push_back({0, 1, 2});
  const CleftCounts counts = count_clefts(statue, level, mesh, 10.0, has_shifted_blocks);
  for (const auto zone : {CleftCounts::kLocked, CleftCounts::kEarlier})
    if (counts.triangles[zone] == 1) {
      EXPECT_NEAR(counts.expected[zone], 1.0, 1e-9);
      return zone;
    }
  return std::nullopt;
}

TEST(BlocksVerify, CleftsAreWhereBlocksHaveBorders) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  const auto zone = [&](int level, std::int32_t x, std::int32_t y, std::int32_t z) {
    return zone_at(*statue, level, x, y, z);
  };
  for (const std::int32_t c : {2048, 6144, 2038, 2058}) {
    EXPECT_EQ(zone(2, c, 1000, 1000), CleftCounts::kLocked) << c;
    EXPECT_EQ(zone(2, 1000, c, 1000), CleftCounts::kLocked) << c;
    EXPECT_EQ(zone(1, 1000, 1000, c), CleftCounts::kEarlier) << c;
  }
  for (const std::int32_t c : {1, 1024, 2037, 2059, 4096, 8191}) {
    EXPECT_EQ(zone(2, 1000, 1000, c), std::nullopt) << c;
  }
  EXPECT_EQ(zone(1, 4096, 1000, 1000), CleftCounts::kLocked);
  EXPECT_EQ(zone(1, 4096, 2048, 1000), CleftCounts::kLocked);
  EXPECT_EQ(zone(1, 1000, 1000, 1000), std::nullopt);
  // The one block of level 1 has its borders around the root.
  EXPECT_EQ(zone(0, 4096, 1000, 1000), CleftCounts::kEarlier);
  EXPECT_EQ(zone(0, 8190, 1000, 1000), std::nullopt);
  EXPECT_EQ(zone(3, 2048, 4096, 2048), std::nullopt);
  // Not shifted, level 3 has borders at 4096, level 4, if there were one, at 2048 too.
  EXPECT_EQ(zone_at(*statue, 2, 4096, 1000, 1000, false), CleftCounts::kLocked);
  EXPECT_EQ(zone_at(*statue, 2, 2048, 6144, 1000, false), std::nullopt);
  EXPECT_EQ(zone_at(*statue, 1, 4096, 1000, 1000, false), CleftCounts::kEarlier);
}

TEST(BlocksVerify, CleftDensitiesAreComparedWithTheRestOfTheCube) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  // Of one plane: squares of side 4 between the borders, four triangles in one square on a border.
  codec::coded::CodedNode mesh = codec::coded::lattice_node();
  std::vector<mesh::Triangle>& triangles = mesh.parts[0].triangles;
  std::vector<geometry::Point> positions;
  const auto add_square = [&](std::int32_t x, std::int32_t y) {
    const auto base = static_cast<std::uint32_t>(positions.size());
    for (const auto& [dx, dy] : {std::array{0, 0}, {4, 0}, {4, 4}, {0, 4}, {2, 2}})
      positions.push_back({x + dx, y + dy, 1000});
    return base;
  };
  for (std::int32_t i = 0; i < 10; ++i) {
    const std::uint32_t v = add_square(1000 + 4 * i, 1000);
    triangles.insert(triangles.end(), {{v, v + 1, v + 2}, {v, v + 2, v + 3}});
  }
  const std::uint32_t v = add_square(2048, 1000);
  for (std::uint32_t k = 0; k < 4; ++k) triangles.push_back({v + k, v + (k + 1) % 4, v + 4});
  set_lattice_positions(mesh, positions);
  CleftCounts counts = count_clefts(*statue, 2, mesh, 10.0);
  EXPECT_EQ(counts.triangles[CleftCounts::kLocked], 4U);
  EXPECT_DOUBLE_EQ(counts.expected[CleftCounts::kLocked], 2.0);
  EXPECT_DOUBLE_EQ(counts.densities().locked.value(), 2.0);
  EXPECT_EQ(counts.densities().earlier, std::nullopt);
  // Without an interior to speak of, a cube says nothing.
  triangles.erase(triangles.begin());
  counts.add(count_clefts(*statue, 2, mesh, 10.0));
  EXPECT_EQ(counts.triangles[CleftCounts::kLocked], 4U);
  EXPECT_EQ(CleftCounts{}.densities().locked, std::nullopt);
}

// An error also tells what simplification cut off, which only the way from the input to the node shows.
TEST(BlocksVerify, DoesNotCallAnErrorLooseThatTellsWhatIsMissing) {
  BlocksFixture fixture(torus(128, 40), 0, 0.25, 13);
  auto& node = fixture.nodes.at({});
  node.mesh.parts[0].triangles.resize(node.mesh.parts[0].triangles.size() / 2);
  node.row.error = 2.0;
  const measure::Surface against = fixture.input.surface();
  measure::VerifyOptions options;
  options.against = &against;
  const measure::VerifyReport report = verified(fixture, options);
  EXPECT_LT(report.greatest_ratio, 0.01);
  EXPECT_EQ(report.measured_nodes, 1U);
  EXPECT_EQ(report.loose_nodes, 0U);
  node.row.error = 200.0;
  EXPECT_EQ(verified(fixture, options).loose_nodes, 1U);
}

TEST(BlocksVerify, ReportsAreRepeatable) {
  BlocksFixture fixture(torus(128, 40));
  large_cube(fixture, 2).mesh.parts[0].triangles.pop_back();
  const auto statue = fixture.open();
  EXPECT_EQ(measure::to_text(verify(*statue)), measure::to_text(verify(*statue)));
}

}  // namespace
}  // namespace colossus::verify::blocks
