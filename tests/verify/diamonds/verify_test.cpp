#include "verify/diamonds/verify.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>

#include "core/file.hpp"
#include "support/diamonds_fixture.hpp"

namespace colossus::verify::diamonds {

using namespace support;
namespace {

using codec::coded::CodedPart;

measure::VerifyReport verified(DiamondsFixture& fixture, const measure::VerifyOptions& options = {}) {
  return verify(*fixture.open(), options);
}

// Some tetrahedron of a leaf with a vertex that lies on exactly one face; the vertex.
struct FaceVertex {
  FixtureNode* node = nullptr;
  CodedPart* part = nullptr;
  std::size_t vertex = 0;
  std::size_t face = 0;
};

// On a border edge within that face: its two ends have the mark in common, and one triangle has the edge.
FaceVertex some_face_vertex(DiamondsFixture& fixture, bool wants_leaf) {
  for (auto& [key, node] : fixture.nodes) {
    if (((node.row.flags & container::kNodeIsLeaf) != 0) != wants_leaf || key.first < 2) continue;
    for (CodedPart& part : node.mesh.parts)
      for (const auto& t : part.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
          const auto common =
              static_cast<std::uint8_t>(codec::coded::marks_of(part.positions[t[k]]) &
                                        codec::coded::marks_of(part.positions[t[(k + 1) % 3]]));
          if (std::popcount(codec::coded::marks_of(part.positions[t[k]])) == 1 &&
              common == codec::coded::marks_of(part.positions[t[k]]))
            return {&node, &part, t[k], static_cast<std::size_t>(std::countr_zero(common))};
        }
  }
  ADD_FAILURE() << "no face vertex";
  return {};
}

// Moves weight between two corners of the face, which keeps the vertex on it.
void move_within_face(const FaceVertex& at, std::uint32_t amount) {
  auto& weights = at.part->positions[at.vertex];
  std::array<std::size_t, 3> corners{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (i != at.face) corners[count++] = i;
  const std::size_t from = *std::max_element(
      corners.begin(), corners.end(), [&](std::size_t a, std::size_t b) { return weights[a] < weights[b]; });
  const std::size_t to = from == corners[0] ? corners[1] : corners[0];
  ASSERT_GE(weights[from], amount);
  weights[from] -= amount;
  weights[to] += amount;
}

TEST(Verify, FindsNothingInSoundContainers) {
  for (const int bits : {8, 12, 16}) {
    SCOPED_TRACE(bits);
    DiamondsFixture fixture(torus(40, 24), 100, bits);
    const measure::VerifyReport report = verified(fixture);
    // Eight bits on the root's 2^22 steps pinch thin places together: legal, but counted.
    if (bits > 8) {
      EXPECT_TRUE(report.is_ok()) << to_text(report);
    }
    EXPECT_EQ(report.count(measure::FindingKind::kFace) + report.count(measure::FindingKind::kEdge), 0U)
        << to_text(report);
    EXPECT_EQ(report.count(measure::FindingKind::kBorder), 0U) << to_text(report);
    EXPECT_GT(report.nonempty_faces, 200U);
    EXPECT_EQ(report.nodes, fixture.nodes.size());
  }
}

TEST(Verify, CountsTheSameEdgesAsTheExtractedCuts) {
  DiamondsFixture fixture(torus(40, 24), 100, 8);
  // Some holes, so that there is something to count.
  int nth = 0;
  for (auto& [key, node] : fixture.nodes)
    for (auto& part : node.mesh.parts)
      if (++nth % 5 == 0 && part.triangles.size() > 1) {
        part.triangles.pop_back();
        reorder(part);
      }
  const auto statue = fixture.open();
  const measure::VerifyReport report = verify(*statue);
  ASSERT_EQ(report.levels.size(), statue->deepest_level() + 1);
  for (const measure::LevelReport& level : report.levels) {
    const reader::access::CutMesh mesh = assemble(*statue, cut_at_level(*statue, level.level));
    const Census census = census_of(mesh);
    EXPECT_EQ(level.border_edges, census.border_edges) << level.level;
    EXPECT_EQ(level.nonmanifold_edges, census.nonmanifold_edges) << level.level;
    EXPECT_EQ(level.triangles, mesh.triangles.size()) << level.level;
  }
  EXPECT_GT(report.count(measure::FindingKind::kBorder), 0U);
}

// The report is the same for one thread and many: it is run twice and compared as text.
TEST(Verify, ReportsAreRepeatable) {
  DiamondsFixture fixture(torus(40, 24), 100);
  move_within_face(some_face_vertex(fixture, true), 1);
  const auto statue = fixture.open();
  EXPECT_EQ(measure::to_text(verify(*statue)), measure::to_text(verify(*statue)));
}

TEST(Verify, FindsAFaceVertexRoundedOtherwise) {
  for (const bool wants_leaf : {true, false}) {
    DiamondsFixture fixture(torus(40, 24), 100);
    move_within_face(some_face_vertex(fixture, wants_leaf), 1);
    const measure::VerifyReport report = verified(fixture);
    EXPECT_GE(report.count(measure::FindingKind::kFace), 1U) << to_text(report);
    ASSERT_FALSE(report.findings.empty());
    const std::string text = to_text(report);
    EXPECT_NE(text.find("first edge of only the"), std::string::npos) << text;
  }
}

TEST(Verify, FindsAMovedFaceVertex) {
  DiamondsFixture fixture(torus(40, 24), 100);
  move_within_face(some_face_vertex(fixture, true), 300);
  EXPECT_GE(verified(fixture).count(measure::FindingKind::kFace), 1U);
}

TEST(Verify, FindsADroppedTriangleAtAFaceAndInside) {
  for (const bool at_face : {true, false}) {
    DiamondsFixture fixture(torus(40, 24), 100);
    bool is_dropped = false;
    for (auto& [key, node] : fixture.nodes)
      for (auto& part : node.mesh.parts)
        for (std::size_t i = 0; i < part.triangles.size() && !is_dropped; ++i) {
          const auto& t = part.triangles[i];
          int face_edges = 0;
          for (std::size_t k = 0; k < 3; ++k)
            face_edges += (codec::coded::marks_of(part.positions[t[k]]) &
                           codec::coded::marks_of(part.positions[t[(k + 1) % 3]])) != 0
                              ? 1
                              : 0;
          if (key.first < 3 || (at_face ? face_edges == 0
                                        : codec::coded::marks_of(part.positions[t[0]]) +
                                                  codec::coded::marks_of(part.positions[t[1]]) +
                                                  codec::coded::marks_of(part.positions[t[2]]) !=
                                              0))
            continue;
          part.triangles.erase(part.triangles.begin() + static_cast<std::ptrdiff_t>(i));
          reorder(part);
          is_dropped = true;
        }
    ASSERT_TRUE(is_dropped);
    const measure::VerifyReport report = verified(fixture);
    EXPECT_EQ(report.count(measure::FindingKind::kFace) > 0, at_face) << to_text(report);
    EXPECT_GE(report.count(measure::FindingKind::kBorder), 1U) << to_text(report);
  }
}

TEST(Verify, ComparesWithTheFinestCutWhereTheInputWasNotCounted) {
  DiamondsFixture fixture(torus(40, 24), 100);
  fixture.metadata.counts.clear();
  auto& part = fixture.nodes.begin()->second.mesh.parts.front();
  part.triangles.pop_back();
  reorder(part);
  EXPECT_GE(verified(fixture).count(measure::FindingKind::kBorder), 1U);
}

TEST(Verify, FindsEveryFlippedBitOfAChunk) {
  DiamondsFixture fixture(sphere(3), 100);
  const auto statue = fixture.open();
  const container::NodeRow row = statue->rows()[1];
  for (const std::uint64_t byte : {std::uint64_t{0}, row.stored_bytes / 2, row.stored_bytes - 1}) {
    fixture.write();
    {
      std::fstream file(fixture.path(), std::ios::in | std::ios::out | std::ios::binary);
      file.seekg(static_cast<std::streamoff>(row.offset + byte));
      const int value = file.get();
      file.seekp(static_cast<std::streamoff>(row.offset + byte));
      file.put(static_cast<char>(value ^ 4));
    }
    const reader::diamonds::Statue damaged(fixture.path());
    const measure::VerifyReport report = verify(damaged);
    EXPECT_EQ(report.count(measure::FindingKind::kDamage), 1U);
    ASSERT_FALSE(report.findings.empty());
    EXPECT_NE(report.findings[0].message.find(damaged.name(1)), std::string::npos)
        << report.findings[0].message;
    // What cannot be read is not blamed on its neighbours.
    EXPECT_EQ(report.count(measure::FindingKind::kFace), 0U) << to_text(report);
  }
}

TEST(Verify, FindsAParentErrorSmallerThanAChilds) {
  DiamondsFixture fixture(torus(40, 24), 100);
  fixture.nodes.begin()->second.row.error /= 1e6;
  const measure::VerifyReport report = verified(fixture);
  EXPECT_GE(report.count(measure::FindingKind::kErrorGrowth), 1U);
  EXPECT_EQ(report.total(), report.count(measure::FindingKind::kErrorGrowth)) << to_text(report);
}

TEST(Verify, FindsWrongCounts) {
  DiamondsFixture fixture(sphere(3), 100);
  const auto rows = fixture.open()->rows();
  auto& node = std::next(fixture.nodes.begin(), 2)->second;
  node.row = rows[2];
  node.row.vertices += 1;
  node.keeps_row = true;
  EXPECT_EQ(verified(fixture).count(measure::FindingKind::kDamage), 1U);
}

TEST(Verify, FindsPositionsOutsideTheBounds) {
  DiamondsFixture fixture(sphere(3), 100);
  const auto rows = fixture.open()->rows();
  auto& node = std::next(fixture.nodes.begin(), 2)->second;
  node.row = rows[2];
  node.row.bounds[3] = std::nextafter(node.row.bounds[3], node.row.bounds[0]);
  node.keeps_row = true;
  const measure::VerifyReport report = verified(fixture);
  EXPECT_EQ(report.count(measure::FindingKind::kBounds), 1U) << to_text(report);
  EXPECT_EQ(report.total(), 1U);
}

TEST(Verify, FindsEveryMissingRow) {
  DiamondsFixture whole(sphere(3), 100);
  for (std::size_t missing = 1; missing < whole.nodes.size(); missing += 3) {
    DiamondsFixture fixture(sphere(3), 100);
    const auto node = std::next(fixture.nodes.begin(), static_cast<std::ptrdiff_t>(missing));
    const bool is_leaf = (node->second.row.flags & container::kNodeIsLeaf) != 0;
    fixture.nodes.erase(node);
    const measure::VerifyReport report = verified(fixture);
    EXPECT_GE(report.count(measure::FindingKind::kFace), 1U) << missing;
    if (!is_leaf) {
      EXPECT_GE(report.count(measure::FindingKind::kStructure), 1U) << missing;
    }
  }
}

TEST(Verify, FindsWrongLeafFlags) {
  DiamondsFixture fixture(torus(40, 24), 100);
  for (auto& [key, node] : fixture.nodes)
    if (key.first == 2) {
      node.row.flags = container::kNodeIsLeaf;
      break;
    }
  EXPECT_GE(verified(fixture).count(measure::FindingKind::kStructure), 1U);
  DiamondsFixture other(torus(40, 24), 100);
  other.nodes.rbegin()->second.row.flags = 0;
  EXPECT_GE(verified(other).count(measure::FindingKind::kStructure), 1U);
}

// A closed pyramid whose base contains the line y = z = 0 of the root cube's middle exactly, although no
// vertex does: there the surface passes from one quadrant to the opposite one, along an edge of the
// hierarchy.
WorldMesh pyramid_through_a_line() {
  WorldMesh mesh;
  mesh.points = {{-5e7, 3e7, 6e7}, {5e7, 3e7, 6e7}, {5e7, -3e7, -6e7}, {-5e7, -3e7, -6e7}, {0, 3e7, -6e7}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 0, 4}, {2, 1, 4}, {3, 2, 4}, {0, 3, 4}};
  for (int round = 0; round < 3; ++round) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    std::vector<mesh::Triangle> finer;
    for (const auto& t : mesh.triangles) {
      std::array<std::uint32_t, 3> m{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k];
        const std::uint32_t b = t[(k + 1) % 3];
        const auto [found, is_new] =
            middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.points.size()));
        if (is_new) {
          const measure::WorldPoint p = mesh.points[a];
          const measure::WorldPoint q = mesh.points[b];
          mesh.points.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
        }
        m[k] = found->second;
      }
      finer.insert(finer.end(),
                   {{t[0], m[0], m[2]}, {m[0], t[1], m[1]}, {m[2], m[1], t[2]}, {m[0], m[1], m[2]}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

TEST(Verify, KnowsSurfacesAlongEdgesOfTheHierarchy) {
  // The world's origin in the middle of the root cube.
  const geometry::Lattice lattice{{-67108864.125, -67108864.25, -67108864.5}, 0.125};
  DiamondsFixture fixture(pyramid_through_a_line(), 60, 12, lattice);
  const auto statue = fixture.open();
  const measure::VerifyReport report = verify(*statue);
  // Vertices a few lattice units from the line may be pinched together with it by quantisation; nothing else.
  EXPECT_EQ(report.total(), report.count(measure::FindingKind::kNonManifold)) << to_text(report);
  EXPECT_GE(report.edges, 2U) << to_text(report);
  for (const measure::LevelReport& level : report.levels)
    EXPECT_EQ(census_of(assemble(*statue, cut_at_level(*statue, level.level))).border_edges, 0U);

  bool is_dropped = false;
  for (auto& [key, node] : fixture.nodes)
    for (auto& part : node.mesh.parts)
      for (std::size_t i = 0; i < part.triangles.size() && !is_dropped; ++i) {
        const auto& t = part.triangles[i];
        for (std::size_t k = 0; k < 3; ++k)
          is_dropped = is_dropped || std::popcount(static_cast<std::uint8_t>(
                                         codec::coded::marks_of(part.positions[t[k]]) &
                                         codec::coded::marks_of(part.positions[t[(k + 1) % 3]]))) == 2;
        if (!is_dropped) continue;
        part.triangles.erase(part.triangles.begin() + static_cast<std::ptrdiff_t>(i));
        reorder(part);
      }
  ASSERT_TRUE(is_dropped);
  EXPECT_GE(verified(fixture).count(measure::FindingKind::kEdge), 1U);
}

// Nothing can be said around an edge of a tetrahedron that cannot be read.
TEST(Verify, DoesNotBlameEdgesOfTheHierarchyForDamage) {
  const geometry::Lattice lattice{{-67108864.125, -67108864.25, -67108864.5}, 0.125};
  DiamondsFixture fixture(pyramid_through_a_line(), 60, 12, lattice);
  const auto statue = fixture.open();
  const std::uint64_t pinched = verify(*statue).count(measure::FindingKind::kNonManifold);
  for (reader::access::RowIndex row = 0; row < statue->rows().size(); ++row) {
    fixture.write();
    {
      std::fstream file(fixture.path(), std::ios::in | std::ios::out | std::ios::binary);
      const auto place = static_cast<std::streamoff>(statue->rows()[row].offset + 9);
      file.seekg(place);
      const int value = file.get();
      file.seekp(place);
      file.put(static_cast<char>(value ^ 4));
    }
    const measure::VerifyReport report = verify(reader::diamonds::Statue(fixture.path()));
    EXPECT_EQ(report.count(measure::FindingKind::kDamage), 1U) << to_text(report);
    EXPECT_LE(report.total(), 1U + pinched) << to_text(report);
    EXPECT_EQ(report.total(), 1U + report.count(measure::FindingKind::kNonManifold)) << to_text(report);
  }
}

TEST(Verify, MeasuresTheErrorsAgainstTheInput) {
  const WorldMesh input = torus(40, 24);
  const measure::Surface against = input.surface();
  measure::VerifyOptions options;
  options.against = &against;
  options.samples_per_node = 500;
  DiamondsFixture fixture(input, 100);
  const measure::VerifyReport report = verified(fixture, options);
  EXPECT_EQ(report.count(measure::FindingKind::kDistance), 0U) << to_text(report);
  EXPECT_GT(report.samples, 400U * fixture.nodes.size() / 2);
  EXPECT_GT(report.greatest_ratio, 0.05);
  EXPECT_LE(report.greatest_ratio, 1.0);

  DiamondsFixture loose(input, 100);
  for (auto& [key, node] : loose.nodes) node.row.error *= 1000.0;
  const measure::VerifyReport loose_report = verified(loose, options);
  EXPECT_EQ(loose_report.count(measure::FindingKind::kLooseError), 1U) << to_text(loose_report);
  EXPECT_EQ(loose_report.count(measure::FindingKind::kDistance), 0U);

  DiamondsFixture tight(input, 100);
  for (auto& [key, node] : tight.nodes) node.row.error *= 0.02;
  EXPECT_GT(verified(tight, options).count(measure::FindingKind::kDistance), tight.nodes.size() / 3);
}

TEST(Verify, BoundsTheExamplesButCountsAll) {
  DiamondsFixture fixture(torus(40, 24), 100);
  for (auto& [key, node] : fixture.nodes) node.row.error = key.first;
  measure::VerifyOptions options;
  options.examples_per_kind = 2;
  const measure::VerifyReport report = verified(fixture, options);
  EXPECT_EQ(report.findings.size(), 2U);
  EXPECT_GT(report.count(measure::FindingKind::kErrorGrowth), 50U);
}

}  // namespace
}  // namespace colossus::verify::diamonds
