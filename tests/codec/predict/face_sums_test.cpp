// What normals are predicted from, against plain integers: the fast ways yield what the slow ones do.
#include "codec/predict/face_sums.hpp"

#include <gtest/gtest.h>

#include <random>

#include "codec/predict/basis.hpp"
#include "codec/predict/projections.hpp"

namespace colossus::codec::predict {
namespace {

using Random = std::mt19937_64;

std::uint32_t pick(Random& random, std::uint32_t low, std::uint32_t high) {
  return std::uniform_int_distribution<std::uint32_t>(low, high)(random);
}

constexpr int kPositionBits = 16;

coded::CodedPart part_of(const std::vector<coded::Coordinates>& positions,
                         const std::vector<mesh::Triangle>& triangles) {
  coded::CodedPart part;
  part.positions = positions;
  part.triangles = triangles;
  return part;
}

// Any triangles of points in a cube, in some frame.
coded::CodedPart random_part(Random& random, std::uint32_t size) {
  std::vector<coded::Coordinates> positions(pick(random, 1, 40));
  const std::uint32_t base = pick(random, 0, (1 << kPositionBits) - size);
  for (coded::Coordinates& p : positions)
    for (std::size_t i = 0; i < 4; ++i) p[i] = base + pick(random, 0, size);
  std::vector<mesh::Triangle> triangles(pick(random, 0, 100));
  const auto last = static_cast<std::uint32_t>(positions.size() - 1);
  for (mesh::Triangle& t : triangles)
    for (auto& v : t) v = pick(random, 0, last);
  coded::CodedPart part = part_of(positions, triangles);
  for (auto& row : part.frame)
    for (auto& entry : row)
      entry = static_cast<std::int8_t>(static_cast<int>(pick(random, 0, 2 * coded::kGreatestFrameEntry)) -
                                       coded::kGreatestFrameEntry);
  return part;
}

// Shifted down to kSumBits.
void expect_equal(const Buffer<FaceSum>& narrow, const Buffer<FaceSum>& wide) {
  ASSERT_EQ(narrow.size(), wide.size());
  for (std::size_t v = 0; v < wide.size(); ++v) {
    const auto& n = narrow[v].components;
    const int excess = excess_bits(n[0], n[1], n[2], kSumBits);
    for (std::size_t i = 0; i < 3; ++i) ASSERT_EQ(n[i] >> excess, wide[v].components[i]) << "vertex " << v;
  }
}

TEST(FaceSums, AreTheSameNarrowAndWide) {
  int narrow_count = 0;
  int wide_count = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const coded::CodedPart part = random_part(random, 1U << pick(random, 0, kPositionBits));
    for (const std::int32_t own_weight : {0, 3, 8}) {
      const auto narrow = narrow_face_sums(kPositionBits, part, own_weight);
      ++(narrow ? narrow_count : wide_count);
      if (narrow) expect_equal(*narrow, wide_face_sums(kPositionBits, part, own_weight));
    }
  }
  EXPECT_GT(narrow_count, 2000);
  EXPECT_GT(wide_count, 1000);
}

TEST(FaceSums, AreThoseOfPlainIntegers) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const coded::CodedPart part = random_part(random, 1U << pick(random, 0, kPositionBits));
    std::vector<LongVector> points;
    for (const coded::Coordinates& w : part.positions) {
      LongVector& point = points.emplace_back();
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t row = 0; row < 3; ++row) point[axis] += std::int64_t{w[row]} * part.frame[row][axis];
    }
    std::vector<LongVector> expected(points.size());
    for (const auto& t : part.triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto along = [&](std::size_t end, std::size_t axis) {
          return points[t[end]][axis % 3] - points[t[0]][axis % 3];
        };
        const std::int64_t n = along(1, i + 1) * along(2, i + 2) - along(1, i + 2) * along(2, i + 1);
        for (const auto v : t) expected[v][i] += n;
      }
    const Buffer<FaceSum> wide = wide_face_sums(kPositionBits, part, 0);
    for (std::size_t v = 0; v < expected.size(); ++v) {
      const auto& [x, y, z] = expected[v];
      const int excess = excess_bits(x, y, z, kSumBits);
      ASSERT_EQ(wide[v].components[0], z >> excess);
      ASSERT_EQ(wide[v].components[1], x >> excess);
      ASSERT_EQ(wide[v].components[2], y >> excess);
    }
  }
}

// A fan of equal triangles, as large as they may be, around one edge.
TEST(FaceSums, AreNarrowUpToTheLimits) {
  const auto fan = [](std::uint32_t edge, std::size_t triangle_count) {
    return part_of({{edge, 0, edge, 0}, {0, 0, 2 * edge, 0}, {0, edge, 0, 0}},
                   std::vector<mesh::Triangle>(triangle_count, {0, 1, 2}));
  };
  const auto narrow = narrow_face_sums(kPositionBits, fan(1448, 511), 0);
  ASSERT_TRUE(narrow);
  // Edges (-e, 0, e) and (-e, e, -e): their product is e^2 * (-1, -2, -1).
  EXPECT_EQ((*narrow)[0].components[1], -511 * 1448 * 1448);
  EXPECT_EQ((*narrow)[0].components[2], -2 * 511 * 1448 * 1448);
  expect_equal(*narrow, wide_face_sums(kPositionBits, fan(1448, 511), 0));
  EXPECT_FALSE(narrow_face_sums(kPositionBits, fan(1449, 511), 0));
  EXPECT_FALSE(narrow_face_sums(kPositionBits, fan(1448, 512), 0));
  // Smoothed, sums are 68 times as large.
  EXPECT_TRUE(narrow_face_sums(kPositionBits, fan(1448, 30), 0));
  EXPECT_FALSE(narrow_face_sums(kPositionBits, fan(1448, 30), 8));
}

struct Place {
  std::uint32_t u = 128;
  std::uint32_t v = 128;
  bool u_is_above = true;
  bool v_is_above = true;
  bool is_folded = false;
};

// 255 * (x / sum + 1) / 2 to the nearest, by integers.
Place place_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  Place place;
  if ((x | y | z) == 0) return place;
  const int excess = excess_bits(x, y, z, kSumBits);
  x >>= excess;
  y >>= excess;
  z >>= excess;
  const std::int64_t sum = std::abs(x) + std::abs(y) + std::abs(z);
  const std::int64_t scale = (std::int64_t{255} << 23) / sum;
  const std::int64_t u = (x + sum) * scale + (1 << 23);
  const std::int64_t v = (y + sum) * scale + (1 << 23);
  place.u = static_cast<std::uint32_t>(u >> 24);
  place.v = static_cast<std::uint32_t>(v >> 24);
  place.u_is_above = (u >> 23 & 1) != 0;
  place.v_is_above = (v >> 23 & 1) != 0;
  place.is_folded = z < 0;
  return place;
}

TEST(Projections, AreThoseOfPlainIntegers) {
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  std::vector<std::array<std::int32_t, 3>> sums;
  for (const std::int32_t x : {0, 1, -1, 2, -2, 16383, 16384, -16384, -16385, 33554431, kMost, -kMost - 1})
    for (const std::int32_t y : {0, 1, -1, 16384, -16385, 33554431, kMost, -kMost - 1})
      for (const std::int32_t z : {0, 1, -1, 3, -16384, 33554432, kMost, -kMost - 1})
        sums.push_back({x, y, z});
  constexpr std::uint64_t kSeed = 1;
  Random random(kSeed);
  while (sums.size() < 200001) {
    const std::uint32_t shift = pick(random, 0, 31);
    auto& sum = sums.emplace_back();
    for (auto& component : sum)
      component = static_cast<std::int32_t>(random()) >> std::min(31U, shift + pick(random, 0, 4));
  }
  Buffer<FaceSum> buffer(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i)
    buffer[i].components = {sums[i][2], sums[i][0], sums[i][1], static_cast<std::int32_t>(i)};
  const Projections projections = project(buffer);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const auto& [x, y, z] = sums[i];
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", sum " << x << " " << y << " " << z);
    const Place place = place_of(x, y, z);
    ASSERT_EQ(projections.u[i] >> kPoint, place.u);
    ASSERT_EQ(projections.v[i] >> kPoint, place.v);
    ASSERT_EQ((projections.u[i] & kHalf) != 0, place.u_is_above);
    ASSERT_EQ((projections.v[i] & kHalf) != 0, place.v_is_above);
    ASSERT_EQ((projections.u[i] & 1) != 0, place.is_folded);
  }
}

}  // namespace
}  // namespace colossus::codec::predict
