#include "pipeline/buckets/bucket_tree.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace colossus::pipeline::buckets {
namespace {

using geometry::kRootSide;
using geometry::Point;

std::uint64_t seed() {
  const char* text = std::getenv("COLOSSUS_TEST_SEED");
  return text == nullptr ? 1 : std::strtoull(text, nullptr, 10);
}

// Splits cubes at random, those along one path to the level where cubes have a side of one.
void split(const CubeId& cube, int most_level, bool is_on_path, std::mt19937_64& random,
           std::vector<CubeId>& cubes) {
  // One in sixteen, below some levels: more would make cubes beyond number.
  if (cube.level == most_level || !(is_on_path || random() % (cube.level < 4 ? 3 : 16) == 0)) {
    cubes.push_back(cube);
    return;
  }
  const int next = static_cast<int>(random() % 8);
  for (int octant = 0; octant < 8; ++octant)
    split(cube.child(octant), most_level, is_on_path && octant == next, random, cubes);
}

std::vector<CubeId> random_cubes(int most_level, std::mt19937_64& random) {
  std::vector<CubeId> cubes;
  split({}, most_level, true, random, cubes);
  return cubes;
}

std::int32_t side_of(const CubeId& cube) { return kRootSide >> cube.level; }

Point low_of(const CubeId& cube) {
  const std::int32_t side = side_of(cube);
  return {cube.x * side, cube.y * side, cube.z * side};
}

// Half of them beside a corner of some cube: there the faces are.
Point random_point(const std::vector<CubeId>& cubes, std::mt19937_64& random) {
  const auto any = [&] { return static_cast<std::int32_t>(random() % kRootSide); };
  if (random() % 2 == 0) return {any(), any(), any()};
  Point p = low_of(cubes[random() % cubes.size()]);
  for (int axis = 0; axis < 3; ++axis)
    p[axis] = std::clamp(p[axis] + static_cast<std::int32_t>(random() % 3) - 1, 0, kRootSide - 1);
  return p;
}

bool meets(const CubeId& cube, const Point& low, const Point& high) {
  const Point from = low_of(cube);
  for (int axis = 0; axis < 3; ++axis)
    if (high[axis] < from[axis] || low[axis] >= std::int64_t{from[axis]} + side_of(cube)) return false;
  return true;
}

// To 3 levels one table does, to 9 the root's and inner ones, to 30 tables within tables.
class BucketTrees : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(OfDepth, BucketTrees, ::testing::Values(0, 1, 3, 7, 8, 9, 12, 20, 30));

TEST_P(BucketTrees, EveryPointIsInTheOneCubeThatContainsIt) {
  std::mt19937_64 random(seed());
  SCOPED_TRACE(seed());
  const std::vector<CubeId> cubes = random_cubes(GetParam(), random);
  const BucketTree tree(cubes);
  ASSERT_TRUE(std::equal(cubes.begin(), cubes.end(), tree.cubes().begin(), tree.cubes().end()));
  for (int i = 0; i < 2000; ++i) {
    const Point p = random_point(cubes, random);
    const std::uint32_t found = tree.at(p);
    std::vector<std::uint32_t> containing;
    for (std::uint32_t c = 0; c < cubes.size(); ++c)
      if (cubes[c].contains(p, geometry::kRootBits)) containing.push_back(c);
    ASSERT_EQ(containing, std::vector<std::uint32_t>{found}) << p.x << " " << p.y << " " << p.z;
  }
}

TEST_P(BucketTrees, FindTheCubesThatABoxMeets) {
  std::mt19937_64 random(seed() + 1);
  SCOPED_TRACE(seed() + 1);
  const std::vector<CubeId> cubes = random_cubes(GetParam(), random);
  const BucketTree tree(cubes);
  std::vector<std::uint32_t> met{12345};  // what was there goes
  for (int i = 0; i < 500; ++i) {
    Point low = random_point(cubes, random);
    Point high = low;
    const int size = static_cast<int>(random() % 31);
    for (int axis = 0; axis < 3; ++axis)
      high[axis] = static_cast<std::int32_t>(std::min<std::int64_t>(
          std::int64_t{low[axis]} + static_cast<std::int64_t>(random() % (std::uint64_t{1} << size)),
          kRootSide - 1));
    tree.find(low, high, met);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t c = 0; c < cubes.size(); ++c)
      if (meets(cubes[c], low, high)) expected.push_back(c);
    ASSERT_EQ(met, expected);
  }
}

}  // namespace
}  // namespace colossus::pipeline::buckets
