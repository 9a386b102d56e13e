// The estimate's shape; how near it comes is looked at by program.report.estimate.
#include "pipeline/estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "hierarchy/diamond.hpp"
#include "hierarchy/octree.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline {
namespace {

facts::Catalog catalog_of(std::uint64_t triangles) {
  facts::Catalog catalog;
  catalog.counts.triangles = triangles;
  catalog.counts.vertices = triangles / 2 + 2;
  catalog.input_block_vertices = triangles * 6 / 10;
  return catalog;
}

ingest::Occupancy empty_ball() {
  ingest::Occupancy occupancy;
  for (int x = 0; x < 128; ++x)
    for (int y = 0; y < 128; ++y)
      for (int z = 0; z < 128; ++z) {
        const double distance = std::hypot(x - 63.5, y - 63.5, z - 63.5);
        if (distance < 62.5 || distance > 63.5) continue;
        occupancy.cells.push_back(
            {{static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), static_cast<std::uint8_t>(z)},
             0,
             0});
      }
  return occupancy;
}

// The cells of a ball's surface.
ingest::Occupancy ball(std::uint64_t vertices) {
  static const ingest::Occupancy empty = empty_ball();
  ingest::Occupancy occupancy = empty;
  for (auto& cell : occupancy.cells)
    cell.vertices = static_cast<std::uint32_t>(vertices / occupancy.cells.size() + 1);
  return occupancy;
}

run::BuildEstimate estimate_of(const facts::BuildOptions& options, const facts::Catalog& catalog,
                               std::uint64_t resident = 0) {
  return estimate(options, catalog, ball(catalog.counts.vertices), resident);
}

class Estimates : public ::testing::TestWithParam<const char*> {
 protected:
  facts::BuildOptions options() const {
    facts::BuildOptions options;
    options.scheme = GetParam();
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(Of, Estimates, ::testing::Values(hierarchy::kDiamonds, hierarchy::kBlocks));

TEST_P(Estimates, ArePositiveForAnyInputAndEveryOption) {
  std::mt19937_64 random(test_seed());
  for (int i = 0; i < 300; ++i) {
    facts::Catalog catalog;
    catalog.counts.triangles = 1 + (random() >> (26 + random() % 38));
    catalog.counts.vertices = 3 + (random() >> (26 + random() % 38));
    catalog.counts.polygons = random() % (catalog.counts.triangles + 1);
    catalog.input_block_vertices = random() % (3 * catalog.counts.triangles + 1);
    catalog.has_normals = random() % 2 == 0;
    catalog.has_colors = random() % 2 == 0;
    catalog.has_face_colors = catalog.has_colors && random() % 2 == 0;
    catalog.has_both_readings = catalog.has_colors && random() % 2 == 0;
    facts::BuildOptions asked = options();
    asked.leaf_triangles = 16 + (random() >> (35 + random() % 25));
    asked.position_bits = 8 + static_cast<int>(random() % 9);
    const auto codecs = codec::codecs();
    asked.codec = codecs[random() % codecs.size()].name;
    ingest::Occupancy occupancy;
    occupancy.cells.push_back(
        {{1, 2, 3},
         0,
         static_cast<std::uint32_t>(std::min<std::uint64_t>(catalog.counts.vertices, 1 << 30))});
    const std::uint64_t resident = random() % (std::uint64_t{1} << 30);
    const run::BuildEstimate needs = estimate(asked, catalog, occupancy, resident);
    EXPECT_GT(needs.memory_bytes_per_rank, resident);
    EXPECT_LT(needs.memory_bytes_per_rank, std::uint64_t{1} << 60);
    EXPECT_GT(needs.scratch_bytes, catalog.counts.triangles);
    EXPECT_LT(needs.scratch_bytes, std::uint64_t{1} << 60);
    EXPECT_GT(needs.output_bytes, 10'000U);
    EXPECT_LT(needs.output_bytes, std::uint64_t{1} << 60);
  }
}

TEST_P(Estimates, GrowWithTheInput) {
  run::BuildEstimate before;
  for (std::uint64_t triangles = 1000; triangles < 1'000'000'000; triangles += triangles / 3) {
    const run::BuildEstimate now = estimate_of(options(), catalog_of(triangles));
    EXPECT_GT(now.scratch_bytes, before.scratch_bytes) << triangles;
    EXPECT_GT(now.output_bytes, before.output_bytes) << triangles;
    if (options().scheme == hierarchy::kDiamonds) {
      EXPECT_GE(now.memory_bytes_per_rank, before.memory_bytes_per_rank) << triangles;
    }
    before = now;
  }
}

TEST_P(Estimates, GrowWithWhatTheInputHas) {
  const facts::Catalog plain = catalog_of(5'000'000);
  const run::BuildEstimate least = estimate_of(options(), plain);
  using Change = void (*)(facts::Catalog&);
  for (const Change change :
       {Change{[](facts::Catalog& c) { c.has_colors = true; }},
        Change{[](facts::Catalog& c) { c.has_normals = true; }},
        Change{[](facts::Catalog& c) { c.has_colors = c.has_face_colors = true; }},
        Change{[](facts::Catalog& c) { c.counts.polygons = 2'500'000; }},
        Change{[](facts::Catalog& c) { c.input_block_vertices = 3 * c.counts.triangles; }}}) {
    facts::Catalog more = plain;
    change(more);
    const run::BuildEstimate needs = estimate_of(options(), more);
    EXPECT_GE(needs.memory_bytes_per_rank, least.memory_bytes_per_rank);
    EXPECT_GE(needs.scratch_bytes, least.scratch_bytes);
    EXPECT_GE(needs.output_bytes, least.output_bytes);
  }
  facts::Catalog shuffled = plain;
  shuffled.has_colors = shuffled.has_face_colors = true;
  shuffled.input_block_vertices = 3 * shuffled.counts.triangles;
  const run::BuildEstimate most = estimate_of(options(), shuffled);
  EXPECT_GT(most.memory_bytes_per_rank, least.memory_bytes_per_rank);
  EXPECT_GT(most.scratch_bytes, least.scratch_bytes);
  EXPECT_GT(most.output_bytes, least.output_bytes);
}

TEST_P(Estimates, GrowWithThePrecision) {
  std::uint64_t before = 0;
  for (int bits = codec::coded::kMinPositionBits; bits <= codec::coded::kMaxPositionBits; ++bits) {
    facts::BuildOptions asked = options();
    asked.position_bits = bits;
    const std::uint64_t now = estimate_of(asked, catalog_of(5'000'000)).output_bytes;
    EXPECT_GT(now, before) << bits;
    before = now;
  }
}

TEST_P(Estimates, AddToWhatIsResident) {
  const facts::Catalog catalog = catalog_of(1'000'000);
  const auto none = estimate_of(options(), catalog, 0);
  const auto some = estimate_of(options(), catalog, 123'456'789);
  EXPECT_EQ(some.memory_bytes_per_rank, none.memory_bytes_per_rank + 123'456'789);
  EXPECT_EQ(some.scratch_bytes, none.scratch_bytes);
  EXPECT_EQ(some.output_bytes, none.output_bytes);
}

TEST(Estimate, OfDiamondsGrowsWithTheirLeaves) {
  facts::BuildOptions options;
  std::uint64_t before = 0;
  for (options.leaf_triangles = 64'000; options.leaf_triangles < 4'000'000; options.leaf_triangles *= 2) {
    const auto now = estimate_of(options, catalog_of(100'000'000)).memory_bytes_per_rank;
    EXPECT_GT(now, before);
    before = now;
  }
}

// Of a level less, blocks have four times the triangles.
TEST(Estimate, OfBlocksGrowsWithTheBlock) {
  facts::BuildOptions options;
  options.scheme = hierarchy::kBlocks;
  const facts::Catalog catalog = catalog_of(400'000'000);
  std::uint64_t before = 0;
  for (const int size : {4, 8, 16, 32}) {
    options.of_scheme["block_size"] = std::int64_t{size};
    const auto now = estimate_of(options, catalog).memory_bytes_per_rank;
    EXPECT_GE(now, before) << size;
    before = now;
  }
  options.of_scheme.clear();
  before = ~std::uint64_t{0};
  for (const int levels : {1, 3, 5, 7}) {
    options.of_scheme["levels"] = std::int64_t{levels};
    const auto now = estimate_of(options, catalog).memory_bytes_per_rank;
    EXPECT_LE(now, before) << levels;
    before = now;
  }
}

// A build of one small mesh, up to the estimate.
std::optional<core::Error> announce(std::uint64_t memory_bytes, std::uint64_t triangles) {
  MadeUpFile file;
  for (int i = 0; i < 100; ++i) file.positions.push_back({1.0 * i, 1.0 * (i % 7), 1.0 * (i % 11)});
  file.triangles.push_back({0, 1, 2});
  const CommonFolder folder;
  const TestBuild build(folder, {}, false, memory_bytes);
  facts::Catalog catalog = store_files(build.workspace(), {file}, 10, 10);
  fit_lattice(catalog, {file});
  catalog.counts.triangles = triangles;
  return error_of([&] { announce_estimate(build.workspace(), catalog, std::uint64_t{50} << 20); });
}

TEST(AnnounceEstimate, LetsPassWhatFits) { EXPECT_FALSE(announce(std::uint64_t{1} << 30, 1000)); }

TEST(AnnounceEstimate, RefusesWhatDoesNotFitIntoMemoryOrOntoTheDisk) {
  const auto memory = announce(std::uint64_t{50} << 20, 1000);
  ASSERT_ALL(memory.has_value());
  EXPECT_EQ(memory->status(), core::Status::kNoResources);
  EXPECT_NE(std::string(memory->what()).find("of memory, but may use 50.0 MB"), std::string::npos)
      << memory->what();
  const auto disk = announce(std::uint64_t{1} << 50, std::uint64_t{1} << 50);
  ASSERT_ALL(disk.has_value());
  EXPECT_EQ(disk->status(), core::Status::kNoResources);
  EXPECT_NE(std::string(disk->what()).find("are free"), std::string::npos) << disk->what();
}

}  // namespace
}  // namespace colossus::pipeline
