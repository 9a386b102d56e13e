#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "core/error.hpp"
#include "exporters/ply.hpp"
#include "reader/blocks/extract.hpp"
#include "support/blocks_fixture.hpp"
#include "verify/blocks/verify.hpp"

namespace colossus::reader::blocks {

using namespace support;
namespace {

using geometry::Point;
using hierarchy::CubeId;

std::set<int> levels_of(const Statue& statue, const Cut& cut) {
  std::set<int> levels;
  for (const access::RowIndex row : cut.rows)
    if (statue.rows()[row].triangles > 0) levels.insert(statue.cube(row).level);
  return levels;
}

// In the bounds of the surface, at most a root side outside, or within an edge length of a vertex.
verify::measure::WorldPoint random_eye(const Statue& statue, std::mt19937_64& random) {
  auto bounds = statue.rows()[0].bounds;
  const auto kind = random() % 3;
  double margin = kind == 1 ? BlocksFixture::kRootSide : 0.0;
  if (kind == 2) {
    const access::RowRange finest = statue.rows_of_level(statue.deepest_level());
    const auto mesh = statue.node(static_cast<access::RowIndex>(finest.first + random() % finest.size()));
    const verify::measure::WorldPoint vertex =
        statue.world(lattice_position(*mesh, random() % mesh->parts[0].positions.size()));
    for (std::size_t axis = 0; axis < 3; ++axis) bounds[axis] = bounds[axis + 3] = vertex[axis];
    margin = statue.longest_edge(static_cast<int>(statue.deepest_level())) * statue.metadata().lattice.step;
  }
  verify::measure::WorldPoint eye{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    eye[axis] =
        std::uniform_real_distribution<double>(bounds[axis] - margin, bounds[axis + 3] + margin)(random);
  return eye;
}

TEST(BlocksCut, LevelsAreWholeAndUnmorphed) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  for (std::uint32_t level = 0; level <= 5; ++level) {
    const Cut cut = cut_at_level(*statue, level);
    EXPECT_FALSE(cut.morph.has_value());
    const int expected = std::min(3, static_cast<int>(level));
    EXPECT_EQ(levels_of(*statue, cut), std::set<int>{expected});
    const access::CutMesh mesh = assemble(*statue, cut);
    EXPECT_EQ(census_of(mesh).border_edges, 0U) << level;
    EXPECT_EQ(census_of(mesh).repeated_points, 0U) << level;
    std::uint64_t stored = 0;
    for (const auto& [cube, node] : fixture.nodes)
      if (cube.level == expected) stored += node.mesh.parts[0].triangles.size();
    EXPECT_EQ(mesh.stored_triangles, stored);
  }
}

TEST(BlocksCut, ErrorChoosesTheCoarsestLevelThatIsGoodEnough) {
  BlocksFixture fixture(torus(128, 40));
  fixture.nodes.rbegin()->second.row.error = 1.5;
  const auto statue = fixture.open();
  EXPECT_EQ(levels_of(*statue, cut_with_error(*statue, 4.0)), std::set<int>{0});
  EXPECT_EQ(levels_of(*statue, cut_with_error(*statue, 3.0)), std::set<int>{1});
  EXPECT_EQ(levels_of(*statue, cut_with_error(*statue, 1.5)), std::set<int>{3});
  EXPECT_TRUE(cut_with_error(*statue, 1.5).warning.empty());
  const Cut finest = cut_with_error(*statue, 1.0);
  EXPECT_EQ(levels_of(*statue, finest), std::set<int>{3});
  EXPECT_NE(finest.warning.find("1.5"), std::string::npos);
}

TEST(BlocksCut, TrianglesChooseTheFinestLevelThatFits) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  for (int level = 0; level <= 3; ++level) {
    std::uint64_t count = 0;
    for (const auto& [cube, node] : fixture.nodes)
      if (cube.level == level) count += node.mesh.parts[0].triangles.size();
    EXPECT_EQ(levels_of(*statue, cut_with_triangles(*statue, count)), std::set<int>{level});
    const Cut fewer = cut_with_triangles(*statue, count - 1);
    EXPECT_EQ(levels_of(*statue, fewer), std::set<int>{std::max(0, level - 1)});
    EXPECT_EQ(fewer.warning.empty(), level > 0);
  }
}

TEST(BlocksCut, DistanceToACubeIsZeroInsideAndRightWithinItsSlab) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  const CubeId cube{2, 1, 2, 3};
  const double side = 2048.0;  // 13 bits, level 2
  const auto distance = [&](double x, double y, double z) {
    return Morph(*statue, statue->world(std::array<double, 3>{x * side, y * side, z * side}), 2.0)
        .distance(cube);
  };
  EXPECT_EQ(distance(1.5, 2.5, 3.5), 0.0);
  EXPECT_EQ(distance(1.0, 2.0, 4.0), 0.0);
  // In the slab of y and z: Li's formula says half a side for an eye that is farther away.
  EXPECT_EQ(distance(0.0, 2.5, 3.5), side);
  EXPECT_EQ(distance(4.0, 2.5, 3.5), 2 * side);
  EXPECT_EQ(distance(1.25, 2.5, 5.0), side);
  EXPECT_EQ(distance(0.5, 0.5, 3.5), 1.5 * side);
}

TEST(BlocksCut, LambdaIsExactOutsideTheBand) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  const Morph morph(*statue, statue->world(Point{0, 0, 0}), 2.0);
  // Level 3, side 1024: from 3.25 to 3.5 sides.
  EXPECT_EQ(morph.lambda({3328, 0, 0}, 3), 1.0);
  EXPECT_LT(morph.lambda({3329, 0, 0}, 3), 1.0);
  EXPECT_EQ(morph.lambda({0, 3456, 17}, 3), 0.5);
  EXPECT_GT(morph.lambda({0, 0, 3583}, 3), 0.0);
  EXPECT_EQ(morph.lambda({0, 0, 3584}, 3), 0.0);
  EXPECT_EQ(morph.lambda({0, 0, 8192}, 3), 0.0);
  EXPECT_EQ(morph.lambda({8192, 8192, 8192}, 0), 1.0);
}

TEST(BlocksCut, RefusesAnIllegalKappaAndTellsTheLeastLegalOne) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  EXPECT_EQ(least_kappa(*statue), std::nextafter(1.75, 2.0));
  EXPECT_EQ(default_kappa(*statue), 2.0);
  EXPECT_NO_THROW(cut_at_eye(*statue, {{0, 0, 0}, least_kappa(*statue)}));
  for (const double kappa : {1.75, 0.0, -1.0, std::nan(""), HUGE_VAL}) {
    try {
      cut_at_eye(*statue, {{0, 0, 0}, kappa});
      FAIL() << kappa;
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), core::Status::kUsage);
      EXPECT_NE(std::string(error.what()).find(fmt::format("{}", least_kappa(*statue))), std::string::npos)
          << error.what();
    }
  }
  EXPECT_THROW(cut_at_eye(*statue, {{0, HUGE_VAL, 0}, 2.0}), core::Error);
}

TEST(BlocksCut, DefaultKappaIsLegalWhereTwoIsNot) {
  BlocksFixture fixture(torus(128, 40), 2, 0.4);
  const auto statue = fixture.open();
  EXPECT_EQ(default_kappa(*statue), least_kappa(*statue) * 1.05);
  EXPECT_NO_THROW(cut_at_eye(*statue, {{0, 0, 0}, std::nullopt}));
}

// Straight from the definition: suitable, or as fine as it gets, and no cube above it is suitable.
TEST(BlocksCut, DrawsSuitableCubesWithUnsuitableAncestors) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  std::mt19937_64 random(5);
  for (int i = 0; i < 50; ++i) {
    const Cut cut = cut_at_eye(*statue, {random_eye(*statue, random), 2.0});
    std::vector<access::RowIndex> expected;
    for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
      CubeId cube = statue->cube(row);
      bool is_drawn = cube.level == 3 || cut.morph->is_suitable(cube);
      while (cube.level > 0) {
        cube = cube.parent();
        is_drawn = is_drawn && !cut.morph->is_suitable(cube);
      }
      if (is_drawn) expected.push_back(row);
    }
    EXPECT_EQ(cut.rows, expected);
  }
}

TEST(BlocksCut, CountsTheCubesThatItDraws) {
  BlocksFixture fixture(torus(128, 40));
  // A cube that is there for its vertices only.
  fixture.nodes.rbegin()->second.mesh.parts[0].triangles.clear();
  const auto statue = fixture.open();
  const std::uint64_t finest = statue->rows_of_level(3).size();
  EXPECT_EQ(parts_by_level(*statue, cut_at_level(*statue, 3)),
            (std::vector<std::uint64_t>{0, 0, 0, finest - 1}));
  const auto& bounds = statue->rows()[0].bounds;
  const Cut cut = cut_at_eye(*statue, {{bounds[0], bounds[1], bounds[2]}, 2.0});
  const std::vector<std::uint64_t> parts = parts_by_level(*statue, cut);
  ASSERT_EQ(parts.size(), 4U);
  std::set<int> drawn;
  for (int level = 0; level <= 3; ++level)
    if (parts[static_cast<std::size_t>(level)] > 0) drawn.insert(level);
  EXPECT_GT(drawn.size(), 1U);
  EXPECT_EQ(drawn, levels_of(*statue, cut));
}

TEST(BlocksCut, MorphedCutsOfAClosedSurfaceAreClosed) {
  BlocksFixture fixture(torus(288, 88), 4);
  const auto statue = fixture.open();
  ASSERT_TRUE(verify::blocks::verify(*statue).is_ok());
  const std::uint64_t seed = 20260101;
  std::mt19937_64 random(seed);
  int mixed_cuts = 0;
  int cracked_without_morphing = 0;
  for (int i = 0; i < 45; ++i) {
    const verify::measure::WorldPoint eye = random_eye(*statue, random);
    double kappa = i % 2 == 0 ? 2.0 : least_kappa(*statue);
    if (i % 3 == 0) kappa *= 1.0 + static_cast<double>(random() % 1000) / 500;
    Cut cut = cut_at_eye(*statue, {eye, kappa});
    const access::CutMesh mesh = assemble(*statue, cut);
    ASSERT_EQ(census_of(mesh).border_edges, 0U) << "seed " << seed << ", eye " << i << ", kappa " << kappa;
    ASSERT_GT(mesh.triangles.size(), 10U);
    if (levels_of(*statue, cut).size() < 2) continue;
    ++mixed_cuts;
    cut.morph.reset();
    if (census_of(assemble(*statue, cut)).border_edges > 0) ++cracked_without_morphing;
  }
  EXPECT_GT(mixed_cuts, 25);
  // The proof that it is the morphing that closes them.
  EXPECT_GT(cracked_without_morphing, mixed_cuts / 2);
}

TEST(BlocksCut, MorphedVerticesLieOnTheWayToTheirParents) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  const auto& bounds = statue->rows()[0].bounds;
  const Cut cut = cut_at_eye(*statue, {{bounds[0], bounds[1], bounds[2]}, 2.0});
  // Three kinds of places where a vertex may be drawn; every drawn point must be one of them, bit by bit.
  std::set<verify::measure::WorldPoint> own;
  std::set<verify::measure::WorldPoint> parents;
  std::set<verify::measure::WorldPoint> between;
  for (const access::RowIndex row : cut.rows) {
    const codec::coded::CodedNode node = statue->load(row);
    const codec::coded::CodedPart& mesh = node.parts[0];
    const int level = statue->cube(row).level;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const Point w = lattice_position(node, i);
      const double lambda = cut.morph->lambda(w, level);
      if (lambda == 1.0) {
        own.insert(statue->world(w));
        continue;
      }
      const Point p = lattice_position(*statue->node(statue->parent(row)), mesh.parents[i]);
      if (lambda == 0.0) {
        parents.insert(statue->world(p));
        continue;
      }
      between.insert(statue->world(std::array<double, 3>{lambda * w.x + (1 - lambda) * p.x,
                                                         lambda * w.y + (1 - lambda) * p.y,
                                                         lambda * w.z + (1 - lambda) * p.z}));
    }
  }
  EXPECT_GT(own.size(), 10U);
  EXPECT_GT(between.size(), 10U);
  const access::CutMesh mesh = assemble(*statue, cut);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
  for (const verify::measure::WorldPoint& p : mesh.positions)
    EXPECT_TRUE(own.contains(p) || parents.contains(p) || between.contains(p));
}

TEST(BlocksCut, FarAndNearEyesGiveTheRootAndTheFinestLevel) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  const access::CutMesh root = assemble(*statue, cut_at_level(*statue, 0));
  for (const double far : {1e3, 1e12, 1e300}) {
    const Cut cut = cut_at_eye(*statue, {{far, 0, -far}, 2.0});
    EXPECT_EQ(levels_of(*statue, cut), std::set<int>{0}) << far;
    // There is nothing to morph it to.
    EXPECT_EQ(assemble(*statue, cut).positions, root.positions) << far;
  }
  const auto& bounds = statue->rows()[0].bounds;
  EXPECT_EQ(levels_of(*statue, cut_at_eye(*statue, {{bounds[0], bounds[1], bounds[2]}, 1e3})),
            std::set<int>{3});
}

TEST(BlocksCut, ExtractsFloatsOrDoublesAsPly) {
  BlocksFixture fixture(torus(128, 40));
  const auto statue = fixture.open();
  const auto path = fixture.folder() / "cut.ply";
  const Cut cut = cut_at_eye(*statue, {{0, 12, 1}, 2.0});
  const access::CutMesh mesh = assemble(*statue, cut);
  const exporters::WrittenPly result = exporters::write_ply(assemble(*statue, cut), path);
  EXPECT_EQ(result.vertices, mesh.positions.size());
  EXPECT_EQ(result.triangles, mesh.triangles.size());
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_FALSE(exporters::write_ply(assemble(*statue, cut_at_level(*statue, 1)), path).has_doubles);
}

TEST(BlocksCut, IsTotalOnNonsense) {
  const std::uint64_t seed = 77;
  for (int round = 0; round < 12; ++round) {
    std::mt19937_64 random(seed + static_cast<std::uint64_t>(round));
    BlocksFixture fixture(torus(128, 40));
    for (int fault = 0; fault < 5; ++fault) {
      auto node =
          std::next(fixture.nodes.begin(), static_cast<std::ptrdiff_t>(random() % fixture.nodes.size()));
      codec::coded::CodedPart& mesh = node->second.mesh.parts[0];
      const auto vertex = random() % mesh.positions.size();
      if (fault == 0) fixture.nodes.erase(node);
      if (fault == 1)
        move_vertex(node->second.mesh, vertex, {8192, 0, static_cast<std::int32_t>(random() % 8193)});
      if (fault == 2 && node->second.mesh.has_parents)
        mesh.parents[vertex] = static_cast<std::uint32_t>(random());
      if (fault == 3) mesh.triangles.clear();
      if (fault == 4) node->second.row.flags ^= container::kNodeIsLeaf;
    }
    const auto statue = fixture.open();
    EXPECT_FALSE(verify::blocks::verify(*statue).is_ok()) << "seed " << seed << ", round " << round;
    for (int i = 0; i < 5; ++i) {
      try {
        assemble(*statue, cut_at_eye(*statue, {random_eye(*statue, random), std::nullopt}));
      } catch (const core::Error& error) {
        EXPECT_EQ(error.status(), core::Status::kBadData) << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace colossus::reader::blocks
