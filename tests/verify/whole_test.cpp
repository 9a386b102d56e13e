// What verify() compares as a whole: the finest level with what is stored of it, orientation, the layout of
// the file, and damage that must be no more than that. Both schemes.
#include <gtest/gtest.h>

#include <fstream>

#include "support/blocks_fixture.hpp"
#include "verify/blocks/verify.hpp"
#include "verify/diamonds/verify.hpp"

namespace colossus::verify {

using namespace support;
using blocks::verify;
using diamonds::verify;
namespace {

using codec::coded::CodedPart;

void expect_only(const measure::VerifyReport& report, std::initializer_list<measure::FindingKind> kinds) {
  std::uint64_t sum = 0;
  for (const measure::FindingKind kind : kinds) {
    EXPECT_GE(report.count(kind), 1U) << name_of(kind) << "\n" << to_text(report);
    sum += report.count(kind);
  }
  EXPECT_EQ(report.total(), sum) << to_text(report);
}

bool is_leaf(const FixtureNode& node) { return (node.row.flags & container::kNodeIsLeaf) != 0; }

// Some triangle of a leaf, or of an inner node, none of whose edges lies in a face.
struct InnerTriangle {
  CodedPart* part = nullptr;
  std::size_t triangle = 0;
  std::uint32_t level = 0;
};
InnerTriangle inner_triangle(DiamondsFixture& fixture, bool wants_leaf) {
  for (auto& [key, node] : fixture.nodes) {
    if (is_leaf(node) != wants_leaf || key.first < 3) continue;
    for (CodedPart& part : node.mesh.parts)
      for (std::size_t i = 0; i < part.triangles.size(); ++i) {
        const auto& t = part.triangles[i];
        if (codec::coded::marks_of(part.positions[t[0]]) == 0 &&
            codec::coded::marks_of(part.positions[t[1]]) == 0 &&
            codec::coded::marks_of(part.positions[t[2]]) == 0)
          return {&part, i, key.first};
      }
  }
  ADD_FAILURE() << "no inner triangle";
  return {};
}

void lose(const InnerTriangle& at) {
  at.part->triangles.erase(at.part->triangles.begin() + static_cast<std::ptrdiff_t>(at.triangle));
  reorder(*at.part);
}

double& measure(container::Metadata& metadata, const std::string& name) {
  return std::find_if(metadata.measures.begin(), metadata.measures.end(),
                      [&](const auto& m) { return m.name == name; })
      ->value;
}
std::uint64_t& count(container::Metadata& metadata, const std::string& name) {
  return std::find_if(metadata.counts.begin(), metadata.counts.end(),
                      [&](const auto& c) { return c.name == name; })
      ->value;
}

// A surface with holes, so that border edges alone say nothing.
void allow_borders(container::Metadata& metadata) { count(metadata, "border_edges") = 5; }

// The loss of one triangle is found by each of what is stored, though the checksum is right.
TEST(Whole, FindsALostTriangleOfALeafByCountBordersAndArea) {
  DiamondsFixture fixture(torus(40, 24), 100);
  allow_borders(fixture.metadata);
  lose(inner_triangle(fixture, true));
  expect_only(verify(*fixture.open()),
              {measure::FindingKind::kCount, measure::FindingKind::kBorder, measure::FindingKind::kArea});
  count(fixture.metadata, "finest_triangles") -= 1;
  expect_only(verify(*fixture.open()), {measure::FindingKind::kBorder, measure::FindingKind::kArea});
  count(fixture.metadata, "finest_border_edges") += 3;
  const measure::VerifyReport report = verify(*fixture.open());
  expect_only(report, {measure::FindingKind::kArea});
  EXPECT_NE(to_text(report).find("the finest level has an area of"), std::string::npos) << to_text(report);
}

TEST(Whole, FindsALostTriangleOfACubeByCountBordersAndArea) {
  // Of one level, so that no map tells.
  BlocksFixture fixture(torus(128, 40), 0, 0.25, 13);
  allow_borders(fixture.metadata);
  fixture.nodes.at({}).mesh.parts[0].triangles.pop_back();
  expect_only(verify(*fixture.open()),
              {measure::FindingKind::kCount, measure::FindingKind::kBorder, measure::FindingKind::kArea});
  count(fixture.metadata, "finest_triangles") -= 1;
  expect_only(verify(*fixture.open()), {measure::FindingKind::kBorder, measure::FindingKind::kArea});
  count(fixture.metadata, "finest_border_edges") += 3;
  expect_only(verify(*fixture.open()), {measure::FindingKind::kArea});
}

TEST(Whole, FindsNonManifoldEdgesOfTheFinestLevel) {
  DiamondsFixture fixture(torus(40, 24), 100);
  count(fixture.metadata, "nonmanifold_edges") = 1;
  count(fixture.metadata, "finest_nonmanifold_edges") += 1;
  expect_only(verify(*fixture.open()), {measure::FindingKind::kNonManifold});
  BlocksFixture blocks(torus(128, 40));
  count(blocks.metadata, "finest_nonmanifold_edges") += 1;
  expect_only(verify(*blocks.open()), {measure::FindingKind::kNonManifold});
}

// What is stored of the finest level may be forged with it; that it is the input's may not.
TEST(Whole, FindsAnAreaThatIsNotTheInputs) {
  for (const bool is_blocks : {false, true}) {
    DiamondsFixture diamonds(torus(40, 24), 100, 16);
    BlocksFixture blocks(torus(128, 40), 0, 0.25, 13);
    container::Metadata& metadata = is_blocks ? blocks.metadata : diamonds.metadata;
    const auto verified = [&] { return is_blocks ? verify(*blocks.open()) : verify(*diamonds.open()); };
    EXPECT_TRUE(verified().is_ok()) << measure::to_text(verified());
    const double area = measure(metadata, "finest_area");
    measure(metadata, "input_area") = area * 1.0009;
    EXPECT_TRUE(verified().is_ok()) << measure::to_text(verified());
    measure(metadata, "input_area") = area * 1.0012;
    expect_only(verified(), {measure::FindingKind::kArea});
    measure(metadata, "input_area") = area * 0.9988;
    expect_only(verified(), {measure::FindingKind::kArea});
    // The build itself has found it, and said so.
    metadata.counts.push_back({"area_differs", 1});
    EXPECT_TRUE(verified().is_ok()) << measure::to_text(verified());
    measure(metadata, "input_area") = area * 2.1;
    expect_only(verified(), {measure::FindingKind::kArea});
    measure(metadata, "input_area") = area * 1.2;
    measure(metadata, "finest_area") = area * (1 + 3e-9);
    expect_only(verified(), {measure::FindingKind::kArea});
  }
}

// Slivers are roughened, so it may be much more.
TEST(Whole, AllowsCoarsePositionsAnotherAreaButNotHalfOfIt) {
  BlocksFixture fixture(torus(128, 40), 3, 0.25, 9);
  const double area = measure(fixture.metadata, "finest_area");
  for (const double factor : {0.3, 0.9, 1.2, 1.9}) {
    measure(fixture.metadata, "input_area") = area * factor;
    EXPECT_TRUE(verify(*fixture.open()).is_ok()) << factor;
  }
  measure(fixture.metadata, "input_area") = area * 2.1;
  expect_only(verify(*fixture.open()), {measure::FindingKind::kArea});
}

// The largest error of a leaf is how far bounds may lie apart, to both sides.
TEST(Whole, FindsMovedBounds) {
  for (const bool is_blocks : {false, true}) {
    DiamondsFixture diamonds(torus(40, 24), 100);
    BlocksFixture blocks(torus(128, 40));
    double error = 0.0;
    for (const auto& [key, node] : diamonds.nodes)
      if (is_leaf(node)) error = std::max(error, node.row.error);
    if (is_blocks) error = 1.0;
    container::Metadata& metadata = is_blocks ? blocks.metadata : diamonds.metadata;
    const auto verified = [&] { return is_blocks ? verify(*blocks.open()) : verify(*diamonds.open()); };
    for (const char* name : {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z"}) {
      const double before = measure(metadata, name);
      for (const double direction : {-1.0, 1.0}) {
        measure(metadata, name) = before + direction * 2.1 * error;
        expect_only(verified(), {measure::FindingKind::kBounds});
        measure(metadata, name) = before + direction * 0.4 * error;
      }
    }
    EXPECT_TRUE(verified().is_ok()) << measure::to_text(verified());
  }
}

TEST(Whole, FindsATriangleTurnedOverInADiamond) {
  for (const bool wants_leaf : {true, false}) {
    DiamondsFixture fixture(torus(40, 24), 100);
    const InnerTriangle at = inner_triangle(fixture, wants_leaf);
    auto& t = at.part->triangles[at.triangle];
    std::swap(t[0], t[1]);
    reorder(*at.part);
    const measure::VerifyReport report = verify(*fixture.open());
    expect_only(report, {measure::FindingKind::kOrientation});
    EXPECT_EQ(report.total(), 1U) << to_text(report);
    EXPECT_NE(to_text(report).find(fmt::format("the nodes of level {} have 3 edges", at.level)),
              std::string::npos)
        << to_text(report);
  }
}

TEST(Whole, FindsATriangleTurnedOverInACube) {
  BlocksFixture fixture(torus(128, 40), 0, 0.25, 13);
  auto& triangles = fixture.nodes.at({}).mesh.parts[0].triangles;
  std::swap(triangles[7][0], triangles[7][1]);
  expect_only(verify(*fixture.open()), {measure::FindingKind::kOrientation});
}

// Inputs may have such edges: then as many must be there.
TEST(Whole, KnowsInconsistentEdgesOfTheInput) {
  WorldMesh mesh = torus(40, 24);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 7)
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  DiamondsFixture fixture(mesh, 100, 16);
  const measure::VerifyReport report = verify(*fixture.open());
  EXPECT_EQ(report.count(measure::FindingKind::kOrientation), 0U) << to_text(report);
  EXPECT_GT(report.levels.back().inconsistent_edges, 0U);
}

// Opposite triangles over the same corners are surface, in both schemes.
TEST(Whole, KeepsPairsOfOppositeTriangles) {
  BlocksFixture fixture(torus(128, 40), 0, 0.25, 13);
  auto& triangles = fixture.nodes.at({}).mesh.parts[0].triangles;
  const std::size_t before = triangles.size();
  triangles.push_back({triangles[0][1], triangles[0][0], triangles[0][2]});
  const measure::VerifyReport report = verify(*fixture.open());
  EXPECT_EQ(report.levels.back().triangles, before + 1);
  EXPECT_EQ(report.levels.back().nonmanifold_edges, 3U);
}

void flip_a_bit(const std::filesystem::path& path, const container::NodeRow& row) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const auto place = static_cast<std::streamoff>(row.offset + row.stored_bytes / 2);
  file.seekg(place);
  const int value = file.get();
  file.seekp(place);
  file.put(static_cast<char>(value ^ 4));
}

template <typename Fixture, typename Opened>
void expect_only_damage(Fixture& fixture, const Opened& statue, const measure::VerifyOptions& options,
                        std::size_t stride) {
  for (reader::access::RowIndex row = 0; row < statue.rows().size();
       row += static_cast<reader::access::RowIndex>(stride)) {
    fixture.write();
    flip_a_bit(fixture.path(), statue.rows()[row]);
    const measure::VerifyReport report = verify(Opened(fixture.path()), options);
    EXPECT_EQ(report.count(measure::FindingKind::kDamage), 1U) << row << to_text(report);
    EXPECT_EQ(report.total(), 1U) << row << to_text(report);
    EXPECT_NE(report.findings[0].message.find(statue.name(row)), std::string::npos) << to_text(report);
  }
}

TEST(Whole, DamageIsDamageAndNothingBesides) {
  const WorldMesh input = sphere(3);
  DiamondsFixture diamonds(input, 100);
  measure::VerifyOptions options;
  expect_only_damage(diamonds, *diamonds.open(), options, 1);
  const measure::Surface surface = input.surface();
  options.against = &surface;
  options.samples_per_node = 100;
  expect_only_damage(diamonds, *diamonds.open(), options, 3);
  BlocksFixture blocks(torus(128, 40));
  blocks.measure_errors();
  expect_only_damage(blocks, *blocks.open(), {}, 7);
  const measure::Surface of_blocks = blocks.input.surface();
  options.against = &of_blocks;
  expect_only_damage(blocks, *blocks.open(), options, 29);
}

// A plate thinner than the lattice: non-manifold from the finest level on, which the build knows.
TEST(Whole, AllowsNonManifoldEdgesThatTheFinestLevelIsSaidToHave) {
  WorldMesh mesh = torus(128, 40);
  const std::size_t before = mesh.triangles.size();
  for (std::size_t i = 0; i < before; i += 50) {
    const mesh::Triangle t = mesh.triangles[i];
    mesh.triangles.push_back({t[1], t[0], t[2]});
  }
  BlocksFixture fixture(mesh);
  set_count(fixture.metadata, "nonmanifold_edges", 0);
  ASSERT_GT(count(fixture.metadata, "finest_nonmanifold_edges"), 0U);
  EXPECT_TRUE(verify(*fixture.open()).is_ok()) << measure::to_text(verify(*fixture.open()));
  set_count(fixture.metadata, "finest_nonmanifold_edges", 0);
  EXPECT_GT(verify(*fixture.open()).count(measure::FindingKind::kNonManifold), 1U);
}

// Nor are its inconsistent edges missed, or its error called loose where nothing is left to measure.
TEST(Whole, DamageIsNotHeldAgainstOrientationOrErrors) {
  WorldMesh turned = sphere(3);
  for (std::size_t i = 0; i < turned.triangles.size(); i += 5)
    std::swap(turned.triangles[i][0], turned.triangles[i][1]);
  DiamondsFixture diamonds(turned, 100);
  const auto statue = diamonds.open();
  EXPECT_EQ(verify(*statue).count(measure::FindingKind::kOrientation), 0U);
  for (reader::access::RowIndex row = 0; row < statue->rows().size(); row += 3) {
    diamonds.write();
    flip_a_bit(diamonds.path(), statue->rows()[row]);
    EXPECT_EQ(verify(reader::diamonds::Statue(diamonds.path())).count(measure::FindingKind::kOrientation), 0U)
        << row;
  }
  measure::VerifyOptions options;
  const WorldMesh input = sphere(2);
  const measure::Surface surface = input.surface();
  options.against = &surface;
  DiamondsFixture one(input, 1000);
  ASSERT_EQ(one.nodes.size(), 1U);
  one.nodes.begin()->second.row.error *= 1000.0;
  expect_only_damage(one, *one.open(), options, 1);
  BlocksFixture blocks(torus(128, 40), 0, 0.25, 13);
  blocks.measure_errors();
  ASSERT_EQ(blocks.nodes.size(), 1U);
  blocks.nodes.at({}).row.error *= 1000.0;
  const measure::Surface of_blocks = blocks.input.surface();
  options.against = &of_blocks;
  expect_only_damage(blocks, *blocks.open(), options, 1);
}

// A level with a damaged node still shows what has nothing to do with it.
TEST(Whole, FindsABorderBesidesDamage) {
  DiamondsFixture fixture(torus(40, 24), 100);
  lose(inner_triangle(fixture, true));
  const auto statue = fixture.open();
  const auto last = static_cast<reader::access::RowIndex>(statue->rows().size() - 1);
  flip_a_bit(fixture.path(), statue->rows()[last]);
  const measure::VerifyReport report = verify(reader::diamonds::Statue(fixture.path()));
  EXPECT_EQ(report.count(measure::FindingKind::kDamage), 1U);
  EXPECT_GE(report.count(measure::FindingKind::kBorder), 1U) << to_text(report);
}

TEST(Whole, SaysWhatOlderContainersDoNotStore) {
  DiamondsFixture fixture(torus(40, 24), 100);
  EXPECT_EQ(measure::to_text(verify(*fixture.open())).find("not checked"), std::string::npos);
  fixture.metadata.measures.clear();
  std::erase_if(fixture.metadata.counts, [](const auto& c) { return c.name.starts_with("finest"); });
  std::erase_if(fixture.metadata.levels, [](const auto& c) { return c.name == "inconsistent_edges"; });
  const measure::VerifyReport report = verify(*fixture.open());
  EXPECT_TRUE(report.is_ok()) << to_text(report);
  ASSERT_EQ(report.notes.size(), 1U);
  EXPECT_NE(report.notes[0].find("finest_area"), std::string::npos) << report.notes[0];
  EXPECT_NE(report.notes[0].find("inconsistent_edges"), std::string::npos) << report.notes[0];
}

TEST(Whole, FindsATableBehindAChunkAndChunksOutOfOrder) {
  DiamondsFixture fixture(sphere(3), 100);
  std::vector<container::NodeRow> rows = fixture.open()->rows();
  const std::uint64_t first = rows.front().offset;
  EXPECT_TRUE(measure::layout_faults(rows, first - 1).empty());
  EXPECT_TRUE(measure::layout_faults(rows, 0).empty());
  // One line, however many chunks lie before it.
  const auto behind = measure::layout_faults(rows, rows[2].offset + 1);
  ASSERT_EQ(behind.size(), 1U);
  EXPECT_NE(behind[0].find("the node table"), std::string::npos) << behind[0];
  std::swap(rows[2].offset, rows[3].offset);
  const auto swapped = measure::layout_faults(rows, first - 1);
  ASSERT_EQ(swapped.size(), 1U);
  EXPECT_NE(swapped[0].find(reader::access::name_of(rows[3])), std::string::npos) << swapped[0];
  rows[5].offset = rows[4].offset;
  EXPECT_EQ(measure::layout_faults(rows, first - 1).size(), 2U);
}

}  // namespace
}  // namespace colossus::verify
