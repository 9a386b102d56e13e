// Which cubes are buckets, and which triangles come into them, on any number of ranks.
#include "pipeline/buckets/buckets.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "pipeline/facts/fingerprint.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::buckets {
namespace {

using geometry::kRootBits;
using geometry::Point;

constexpr std::uint64_t kLimit = std::uint64_t{1} << 17;  // of centroids in a bucket, but for crowded ones

// The triangles as points of the lattice.
using Corners = std::array<Point, 3>;

// Groups of triangles that the ranks have in scratch, and the same triangles in memory.
struct Grouped {
  facts::Catalog catalog;
  std::vector<ingest::TriangleGroup> groups;
  std::vector<Corners> triangles;
  std::vector<bool> has_three_corners;  // of the input
};

Grouped group(const run::Workspace& workspace, const MadeUpFile& file) {
  Grouped grouped;
  grouped.catalog = store_files(workspace, {file}, 50'000, 40'000);
  fit_lattice(grouped.catalog, {file});
  grouped.groups = ingest::request_vertices(workspace, grouped.catalog);
  ingest::answer_requests(workspace, grouped.catalog, grouped.groups);
  for (const mesh::Triangle& t : file.triangles) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = grouped.catalog.lattice.input_vertex(file.positions[t[k]]);
    grouped.triangles.push_back(corners);
    // Corners that only the lattice lets coincide are told apart by their fingerprints, but for one in 2^15.
    const auto is_same = [&](std::size_t a, std::size_t b) {
      return corners[a] == corners[b] &&
             facts::fingerprint_of(file.positions[t[a]]) == facts::fingerprint_of(file.positions[t[b]]);
    };
    grouped.has_three_corners.push_back(!is_same(0, 1) && !is_same(1, 2) && !is_same(2, 0));
  }
  return grouped;
}

// Small triangles that are spread evenly, or crowd around a corner, as many in each octave of the distance
// from it; some degenerate.
MadeUpFile random_triangles(std::size_t count, double crowded_share) {
  std::mt19937_64 random(test_seed());
  std::uniform_real_distribution<double> unit;
  MadeUpFile file;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double scale = unit(random) < crowded_share ? std::exp2(-12.0 * unit(random)) : 1.0;
    const std::array<double, 3> at{scale * unit(random), scale * unit(random), scale * unit(random)};
    for (int k = 0; k < 3; ++k)
      file.positions.push_back({at[0] + 1e-3 * scale * unit(random), at[1] + 1e-3 * scale * unit(random),
                                at[2] + 1e-3 * scale * unit(random)});
    file.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    if (i % 100 == 7) file.triangles.back()[1] = 3 * i;
    if (i % 100 == 8) file.positions[3 * i + 1] = file.positions[3 * i];
    // Its corners are one on the lattice only.
    if (i % 100 == 9) file.positions[3 * i + 1] = file.positions[3 * i];
    if (i % 100 == 9) file.positions[3 * i + 1][0] += 1e-15;
  }
  return file;
}

bool is_degenerate(const Corners& c) { return mesh::is_degenerate(c[0], c[1], c[2]); }

Corners rounded(const Corners& corners, const Rounding& rounding) {
  return {rounding(corners[0]), rounding(corners[1]), rounding(corners[2])};
}

std::map<std::uint32_t, std::uint64_t> centroids_by_bucket(const Grouped& grouped, const BucketTree& tree,
                                                           const Rounding& rounding) {
  std::map<std::uint32_t, std::uint64_t> counts;
  for (const Corners& corners : grouped.triangles) {
    const Corners c = rounded(corners, rounding);
    if (is_degenerate(c)) continue;
    Point centroid;
    for (int axis = 0; axis < 3; ++axis)
      centroid[axis] = static_cast<std::int32_t>((std::int64_t{c[0][axis]} + c[1][axis] + c[2][axis]) / 3);
    ++counts[tree.at(centroid)];
  }
  return counts;
}

// The volumes add up: with the tree's own tests, cubes in the order of a descent tile the root.
void expect_tiling(std::span<const CubeId> cubes) {
  long double volume = 0.0;
  for (const CubeId& cube : cubes) volume += std::ldexp(1.0L, -3 * cube.level);
  EXPECT_EQ(volume, 1.0L);
}

std::vector<CubeId> plan_of(const MadeUpFile& file, const Rounding& rounding, int most_level,
                            std::uint64_t most) {
  const CommonFolder folder;
  const TestBuild build(folder);
  const Grouped grouped = group(build.workspace(), file);
  const BucketPlan plan =
      plan_buckets(build.workspace(), grouped.catalog, grouped.groups, rounding, most_level);
  const auto cubes = plan.tree.cubes();
  expect_tiling(cubes);
  for (const CubeId& cube : cubes) EXPECT_LE(cube.level, most_level);
  const auto counts = centroids_by_bucket(grouped, plan.tree, rounding);
  for (const auto& [bucket, count] : counts)
    if (cubes[bucket].level < most_level) {
      EXPECT_LE(count, most) << bucket;
    }
  std::uint64_t hash = 0;
  for (const CubeId& cube : cubes)
    hash = core::mix64(hash ^ core::hash64(std::as_bytes(std::span(&cube, 1))));
  EXPECT_EQ(world().min<std::uint64_t>(hash >> 1), world().max<std::uint64_t>(hash >> 1))
      << "all ranks have the same";
  EXPECT_GE(plan.piece_count, std::min(counts.size(), grouped.groups.size()));
  return {cubes.begin(), cubes.end()};
}

TEST(BucketPlan, IsOneBucketWhereThereIsLittle) {
  EXPECT_EQ(plan_of(random_triangles(1000, 0.0), {}, 15, kLimit), std::vector<CubeId>{CubeId{}});
}

TEST(BucketPlan, KeepsBucketsOfAnEvenSpreadBelowTheLimit) {
  const auto cubes = plan_of(random_triangles(300'000, 0.0), {}, 15, kLimit);
  EXPECT_EQ(cubes.size(), 8U);
}

TEST(BucketPlan, LooksDeeperIntoACrowd) {
  const auto cubes = plan_of(random_triangles(600'000, 1.0), {}, 25, 2 * kLimit);
  const auto deepest = std::max_element(cubes.begin(), cubes.end(),
                                        [](const CubeId& a, const CubeId& b) { return a.level < b.level; });
  EXPECT_GT(deepest->level, 7) << "one pass counts no deeper";
}

TEST(BucketPlan, EndsAtTheMostDepth) {
  const auto cubes = plan_of(random_triangles(300'000, 1.0), {}, 3, kLimit);
  EXPECT_LE(cubes.size(), 512U);
  EXPECT_EQ(plan_of(random_triangles(200'000, 0.0), {}, 0, kLimit), std::vector<CubeId>{CubeId{}});
}

TEST(BucketPlan, IsOneBucketWhereEightLeavesHoldAll) {
  const CommonFolder folder;
  facts::BuildOptions options;
  options.leaf_triangles = 1'000'000;  // eight leaves hold all
  const TestBuild build(folder, options);
  const Grouped grouped = group(build.workspace(), random_triangles(200'000, 0.0));
  const BucketPlan plan = plan_buckets(build.workspace(), grouped.catalog, grouped.groups, {}, 15);
  EXPECT_EQ(plan.tree.cubes().size(), 1U);
}

// Of each bucket, how often it has a triangle with these corners.
using Content = std::vector<std::map<Corners, int>>;

Content content_of(const run::Workspace& workspace, const facts::Catalog& catalog, const Buckets& buckets) {
  Content content;
  for (const Bucket& bucket : buckets.buckets) {
    content.emplace_back();
    ingest::Piece piece;
    for (const scratch::RecordRef& record : bucket.pieces) load_piece(workspace, catalog, record, piece);
    EXPECT_EQ(piece.triangles.size(), bucket.triangle_count);
    EXPECT_EQ(piece.vertices.size(), bucket.vertex_count);
    for (const mesh::Triangle& t : piece.triangles)
      ++content.back()[{piece.vertices[t[0]].position, piece.vertices[t[1]].position,
                        piece.vertices[t[2]].position}];
  }
  return content;
}

Content expected_content(const Grouped& grouped, const BucketTree& tree, const Rounding& rounding) {
  Content content(tree.cubes().size());
  std::vector<std::uint32_t> met;
  for (std::size_t i = 0; i < grouped.triangles.size(); ++i) {
    if (!grouped.has_three_corners[i]) continue;
    const Corners c = rounded(grouped.triangles[i], rounding);
    Point low = c[0];
    Point high = c[0];
    for (const Point& p : c)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    tree.find(low, high, met);
    for (const auto bucket : met) ++content[bucket][grouped.triangles[i]];
  }
  return content;
}

void expect_filled(const Rounding& rounding, std::uint64_t most_pieces) {
  const CommonFolder folder;
  const TestBuild build(folder);
  Grouped grouped = group(build.workspace(), random_triangles(300'000, 1.0));
  const Buckets buckets =
      fill_buckets(build.workspace(), grouped.catalog, grouped.groups, rounding, {20, most_pieces});
  ASSERT_ALL(buckets.tree.cubes().size() >= 8);
  if (!world().is_root()) return;
  ASSERT_EQ(buckets.buckets.size(), buckets.tree.cubes().size());
  for (std::size_t i = 0; i < buckets.buckets.size(); ++i)
    EXPECT_EQ(buckets.buckets[i].cube, buckets.tree.cubes()[i]);
  EXPECT_TRUE(content_of(build.workspace(), grouped.catalog, buckets) ==
              expected_content(grouped, buckets.tree, rounding));
  std::uint64_t degenerate = 0;
  std::uint64_t collapsed = 0;
  for (std::size_t i = 0; i < grouped.triangles.size(); ++i) {
    if (!grouped.has_three_corners[i])
      ++degenerate;
    else if (is_degenerate(rounded(grouped.triangles[i], rounding)))
      ++collapsed;
  }
  EXPECT_EQ(grouped.catalog.counts.degenerate, degenerate);
  EXPECT_EQ(grouped.catalog.counts.collapsed, collapsed);
  EXPECT_GT(collapsed, 0U);
}

TEST(Buckets, HaveEveryTriangleWhoseBoxMeetsThem) { expect_filled({}, ~std::uint64_t{0}); }
TEST(Buckets, HaveItWhereItLiesAfterRounding) { expect_filled({1 << 8}, ~std::uint64_t{0}); }
TEST(Buckets, AreTheSameInTwoSteps) { expect_filled({}, 0); }

TEST(Rounding, GoesToTheNearestMultiple) {
  std::mt19937_64 random(test_seed());
  for (int i = 0; i < 1000; ++i) {
    const std::int32_t spacing = std::int32_t{1} << (1 + random() % 20);
    const Point p{static_cast<std::int32_t>(random() % (1U << kRootBits)), 5, 7};
    const Point q = Rounding{spacing}(p);
    EXPECT_EQ(q.x % spacing, 0);
    EXPECT_LE(std::abs(q.x - p.x), spacing / 2);
    EXPECT_EQ(Rounding{}(p), p);
  }
}

}  // namespace
}  // namespace colossus::pipeline::buckets
