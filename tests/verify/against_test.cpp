// verify() against the input, both ways. Both schemes.
#include <gtest/gtest.h>

#include <cmath>

#include "support/blocks_fixture.hpp"
#include "verify/blocks/verify.hpp"
#include "verify/diamonds/verify.hpp"

namespace colossus::verify {

using namespace support;
using blocks::verify;
using diamonds::verify;
namespace {

template <typename Opened>
measure::VerifyReport verified_against(const Opened& statue, const WorldMesh& input,
                                       std::size_t samples = 300) {
  const measure::Surface surface = input.surface();
  measure::VerifyOptions options;
  options.against = &surface;
  options.samples_per_node = samples;
  return verify(statue, options);
}

WorldMesh scaled(WorldMesh mesh, double factor) {
  for (auto& p : mesh.points)
    for (double& c : p) c *= factor;
  return mesh;
}

// The triangles on one side of a plane.
WorldMesh half_of(WorldMesh mesh) {
  double middle = 0.0;
  for (const auto& p : mesh.points) middle += p[0] / static_cast<double>(mesh.points.size());
  std::erase_if(mesh.triangles, [&](const auto& t) { return mesh.points[t[0]][0] > middle; });
  return mesh;
}

// Of a part of the surface that an inner level lacks, nothing else tells where the input has borders.
TEST(Against, FindsWhatAnInnerLevelOfDiamondsLacks) {
  const WorldMesh input = torus(40, 24);
  DiamondsFixture fixture(input, 100);
  EXPECT_TRUE(verified_against(*fixture.open(), input).is_ok())
      << measure::to_text(verified_against(*fixture.open(), input));
  for (auto& [key, node] : fixture.nodes) {
    if (key.first != 3 || (node.row.flags & container::kNodeIsLeaf) != 0) continue;
    // All triangles without a corner on a face.
    bool is_changed = false;
    for (auto& part : node.mesh.parts) {
      const std::size_t before = part.triangles.size();
      std::erase_if(part.triangles, [&](const auto& t) {
        return codec::coded::marks_of(part.positions[t[0]]) == 0 &&
               codec::coded::marks_of(part.positions[t[1]]) == 0 &&
               codec::coded::marks_of(part.positions[t[2]]) == 0;
      });
      is_changed = is_changed || part.triangles.size() < before;
      reorder(part);
    }
    if (is_changed) break;
  }
  set_count(fixture.metadata, "border_edges", 9);
  EXPECT_TRUE(verify(*fixture.open()).is_ok());
  const measure::VerifyReport report = verified_against(*fixture.open(), input);
  EXPECT_GE(report.count(measure::FindingKind::kInputDistance), 1U) << to_text(report);
  EXPECT_EQ(report.total(), report.count(measure::FindingKind::kInputDistance)) << to_text(report);
  EXPECT_NE(to_text(report).find("level 3: "), std::string::npos) << to_text(report);
}

TEST(Against, FindsOneTriangleThatTheFinestLevelLacks) {
  const WorldMesh input = torus(40, 24);
  for (std::size_t nth = 0; nth < 2; ++nth) {
    DiamondsFixture fixture(input, 100);
    std::size_t seen = 0;
    for (auto& [key, node] : fixture.nodes) {
      if ((node.row.flags & container::kNodeIsLeaf) == 0) continue;
      for (auto& part : node.mesh.parts)
        for (std::size_t i = 0; i < part.triangles.size() && seen <= nth; ++i) {
          const auto& t = part.triangles[i];
          if ((codec::coded::marks_of(part.positions[t[0]]) | codec::coded::marks_of(part.positions[t[1]]) |
               codec::coded::marks_of(part.positions[t[2]])) != 0 ||
              seen++ < nth)
            continue;
          part.triangles.erase(part.triangles.begin() + static_cast<std::ptrdiff_t>(i));
          reorder(part);
        }
    }
    const measure::VerifyReport report = verified_against(*fixture.open(), input, 10);
    EXPECT_GE(report.count(measure::FindingKind::kInputDistance), 1U) << to_text(report);
  }
}

// Each triangle of the input is sampled at the finest level, however small, and wherever it stands in the
// file.
TEST(Against, SamplesEveryTriangleOfTheInput) {
  const WorldMesh whole = torus(40, 24);
  DiamondsFixture diamonds(whole, 100000);
  BlocksFixture blocks(torus(128, 40), 0, 0.25, 13);
  blocks.measure_errors();
  const auto with_dust = [](WorldMesh mesh, const measure::WorldPoint& at, std::ptrdiff_t place) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mesh.points.push_back(at);
      mesh.points.back()[axis] += 1e-5;
    }
    mesh.triangles.insert(mesh.triangles.begin() + place, {first, first + 1, first + 2});
    return mesh;
  };
  measure::WorldPoint middle{};
  for (const measure::WorldPoint& p : blocks.input.points)
    for (std::size_t axis = 0; axis < 3; ++axis)
      middle[axis] += p[axis] / static_cast<double>(blocks.input.points.size());
  const auto of_diamonds = diamonds.open();
  const auto of_blocks = blocks.open();
  for (std::ptrdiff_t place = 0; place < 8; ++place) {
    const measure::VerifyReport one =
        verified_against(*of_diamonds, with_dust(whole, {0.0, 0.0, 0.0}, place), 10);
    EXPECT_EQ(one.count(measure::FindingKind::kInputDistance), 1U) << place << to_text(one);
    const measure::VerifyReport other =
        verified_against(*of_blocks, with_dust(blocks.input, middle, place), 10);
    EXPECT_EQ(other.count(measure::FindingKind::kInputDistance), 1U) << place << to_text(other);
  }
}

TEST(Against, FindsWhatALevelOfBlocksLacks) {
  for (const int level : {0, 2, 3}) {
    BlocksFixture fixture(torus(128, 40));
    fixture.measure_errors();
    const measure::VerifyReport sound = verified_against(*fixture.open(), fixture.input);
    EXPECT_TRUE(sound.is_ok()) << to_text(sound);
    for (auto& [cube, node] : fixture.nodes)
      if (cube.level == level && node.mesh.parts[0].triangles.size() > 40) {
        node.mesh.parts[0].triangles.resize(node.mesh.parts[0].triangles.size() / 2);
        break;
      }
    const measure::VerifyReport report = verified_against(*fixture.open(), fixture.input);
    EXPECT_GE(report.count(measure::FindingKind::kInputDistance), 1U) << to_text(report);
    EXPECT_NE(to_text(report).find(fmt::format("level {}: ", level)), std::string::npos) << to_text(report);
  }
}

// An error may tell of a spike that was cut off, which only its tip shows.
TEST(Against, DoesNotCallAnErrorLooseThatTellsOfASpike) {
  const WorldMesh input = torus(40, 24);
  DiamondsFixture fixture(input, 100000);
  ASSERT_EQ(fixture.nodes.size(), 1U);
  double& error = fixture.nodes.begin()->second.row.error;
  for (std::size_t i = 0; i < 24; ++i) {
    WorldMesh spiky = input;
    spiky.points[i * 24 + 4 + i % 5][2] += 2.2;  // of the upper side
    error = 6.5;
    EXPECT_EQ(verified_against(*fixture.open(), spiky, 10).loose_nodes, 0U) << i;
    error = 9.0;
    EXPECT_EQ(verified_against(*fixture.open(), spiky, 10).loose_nodes, 1U) << i;
  }
}

// A sound container, but of another statue.
TEST(Against, FindsHalfAStatue) {
  const WorldMesh input = torus(40, 24);
  const WorldMesh half = half_of(input);
  DiamondsFixture of_half(half, 100);
  set_count(of_half.metadata, "border_edges", 48);
  EXPECT_TRUE(verify(*of_half.open()).is_ok()) << measure::to_text(verify(*of_half.open()));
  const measure::VerifyReport report = verified_against(*of_half.open(), input);
  for (const measure::FindingKind kind : {measure::FindingKind::kCount, measure::FindingKind::kBounds,
                                          measure::FindingKind::kArea, measure::FindingKind::kInputDistance})
    EXPECT_GE(report.count(kind), 1U) << name_of(kind) << to_text(report);
  // Every level lacks the other half.
  EXPECT_GE(report.count(measure::FindingKind::kInputDistance), report.levels.size()) << to_text(report);
  DiamondsFixture of_whole(input, 100);
  const measure::VerifyReport other = verified_against(*of_whole.open(), half);
  for (const measure::FindingKind kind : {measure::FindingKind::kCount, measure::FindingKind::kBounds,
                                          measure::FindingKind::kArea, measure::FindingKind::kDistance})
    EXPECT_GE(other.count(kind), 1U) << name_of(kind) << to_text(other);
}

TEST(Against, ComparesCountsBoundsAndAreaOfTheInput) {
  const WorldMesh input = torus(40, 24);
  DiamondsFixture fixture(input, 100);
  const auto expect = [&](measure::FindingKind kind, const char* what) {
    const measure::VerifyReport report = verified_against(*fixture.open(), input, 10);
    EXPECT_EQ(report.count(kind), 1U) << to_text(report);
    EXPECT_EQ(report.total(), 1U) << to_text(report);
    EXPECT_NE(to_text(report).find(what), std::string::npos) << to_text(report);
    fixture.describe(input);
  };
  set_count(fixture.metadata, "vertices", input.points.size() + 1);
  expect(measure::FindingKind::kCount, "vertices, the input has");
  set_count(fixture.metadata, "triangles", input.triangles.size() - 1);
  expect(measure::FindingKind::kCount, "triangles, the input has");
  for (const auto& measure : std::vector(fixture.metadata.measures))
    if (measure.name.find('_') == 3) {
      set_measure(fixture.metadata, measure.name, std::nextafter(measure.value, 0.0));
      expect(measure::FindingKind::kBounds, "the container was built of a statue from");
    }
  for (const auto& measure : std::vector(fixture.metadata.measures))
    if (measure.name == "input_area") {
      set_count(fixture.metadata, "area_differs", 1);
      set_measure(fixture.metadata, "input_area", measure.value * 1.002);
      expect(measure::FindingKind::kArea, "the container was built of a surface of");
    }
}

// Copies, whichever way they look, and triangles without an area are no surface of their own.
TEST(Against, AllowsCopiesAndDegenerateTriangles) {
  const WorldMesh input = torus(40, 24);
  DiamondsFixture fixture(input, 100);
  WorldMesh with_copies = input;
  for (std::size_t i = 0; i < 300; ++i) {
    const mesh::Triangle t = input.triangles[i];
    with_copies.triangles.push_back(i % 2 == 0 ? t : mesh::Triangle{t[1], t[0], t[2]});
  }
  with_copies.points.push_back({50, 0, 0});
  const auto far = static_cast<std::uint32_t>(with_copies.points.size() - 1);
  with_copies.triangles.push_back({0, 0, far});
  set_count(fixture.metadata, "vertices", with_copies.points.size());
  set_count(fixture.metadata, "triangles", with_copies.triangles.size());
  set_count(fixture.metadata, "degenerate", 1);
  EXPECT_TRUE(verified_against(*fixture.open(), with_copies).is_ok())
      << measure::to_text(verified_against(*fixture.open(), with_copies));
  // As a builder may also say it: the bounds reach to the degenerate triangle.
  set_measure(fixture.metadata, "max_x", 50.0);
  EXPECT_TRUE(verified_against(*fixture.open(), with_copies).is_ok())
      << measure::to_text(verified_against(*fixture.open(), with_copies));
  set_count(fixture.metadata, "degenerate", 0);
  EXPECT_EQ(verify(*fixture.open()).count(measure::FindingKind::kBounds), 1U);
}

// Squares of these lengths are no doubles.
TEST(Against, DistancesNeitherOverflowNorVanish) {
  const WorldMesh input = torus(40, 24);
  geometry::Bounds bounds;
  for (const measure::WorldPoint& p : input.points) bounds.add(p);
  const geometry::Lattice lattice = geometry::Lattice::fit(bounds);
  for (const int exponent : {994, -1000}) {
    SCOPED_TRACE(exponent);
    const double factor = std::ldexp(1.0, exponent);
    geometry::Lattice of_scaled = lattice;
    of_scaled.step *= factor;
    for (double& c : of_scaled.origin) c *= factor;
    const WorldMesh statue = scaled(input, factor);
    DiamondsFixture fixture(statue, 100, 12, of_scaled);
    const measure::VerifyReport report = verified_against(*fixture.open(), statue);
    EXPECT_TRUE(report.is_ok()) << to_text(report);
    // As much is seen as at any other size.
    DiamondsFixture usual(input, 100, 12, lattice);
    const measure::VerifyReport expected = verified_against(*usual.open(), input);
    EXPECT_NEAR(report.greatest_ratio, expected.greatest_ratio, 1e-6);
    EXPECT_EQ(report.loose_nodes, expected.loose_nodes);
    for (std::size_t i = 0; i < report.levels.size(); ++i)
      EXPECT_NEAR(report.levels[i].input_ratio, expected.levels[i].input_ratio, 1e-6);

    DiamondsFixture of_half(half_of(statue), 100, 12, of_scaled);
    const measure::VerifyReport of_other = verified_against(*of_half.open(), statue);
    EXPECT_GE(of_other.count(measure::FindingKind::kInputDistance), of_other.levels.size())
        << to_text(of_other);
    EXPECT_GE(of_other.count(measure::FindingKind::kArea), 1U) << to_text(of_other);
    EXPECT_EQ(to_text(of_other).find("inf"), std::string::npos) << to_text(of_other);
    EXPECT_EQ(to_text(of_other).find("nan"), std::string::npos) << to_text(of_other);
    // Nor those from a statue to one of another size.
    EXPECT_GE(verified_against(*fixture.open(), input).count(measure::FindingKind::kDistance), 1U);
    EXPECT_GE(verified_against(*usual.open(), statue).count(measure::FindingKind::kDistance), 1U);
  }
}

TEST(Against, DistancesOfBlocksNeitherOverflowNorVanish) {
  BlocksFixture usual(torus(128, 40));
  usual.measure_errors();
  const measure::VerifyReport expected = verified_against(*usual.open(), usual.input);
  for (const int exponent : {994, -1000}) {
    SCOPED_TRACE(exponent);
    const double factor = std::ldexp(1.0, exponent);
    BlocksFixture fixture(torus(128, 40), 3, 0.25, 10, BlocksFixture::kRootSide * factor);
    for (auto& [cube, node] : fixture.nodes) node.row.error = usual.nodes.at(cube).row.error * factor;
    const measure::VerifyReport report = verified_against(*fixture.open(), fixture.input);
    EXPECT_TRUE(report.is_ok()) << to_text(report);
    EXPECT_NEAR(report.greatest_ratio, expected.greatest_ratio, 1e-6);
    for (std::size_t i = 0; i < report.levels.size(); ++i)
      EXPECT_NEAR(report.levels[i].input_ratio, expected.levels[i].input_ratio, 1e-6);
    fixture.nodes.at({}).mesh.parts[0].triangles.resize(100);
    EXPECT_GE(verified_against(*fixture.open(), fixture.input).count(measure::FindingKind::kInputDistance),
              1U);
  }
}

}  // namespace
}  // namespace colossus::verify
