#include "hierarchy/octree.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <unordered_set>

namespace colossus::hierarchy {
namespace {

using geometry::Point;
using Random = std::mt19937_64;

// Both ends included.
std::int32_t pick(Random& random, std::int64_t low, std::int64_t high) {
  return static_cast<std::int32_t>(std::uniform_int_distribution<std::int64_t>(low, high)(random));
}

CubeId random_cube(Random& random, int level) {
  const std::int64_t last = (std::int64_t{1} << level) - 1;
  return {level, pick(random, 0, last), pick(random, 0, last), pick(random, 0, last)};
}

// Every level that a lattice of so many bits has, by the rule of the container's schema: 1 to 30 bits.
template <typename Visit>
void for_all_lattices(const Visit& visit) {
  for (int root_bits = 1; root_bits <= geometry::kRootBits; ++root_bits)
    for (int level = 0; level < root_bits && level <= kMaxCubeLevel; ++level) visit(root_bits, level);
}

// low <= numerator / 3 < high, without dividing.
bool third_lies_in(__int128 numerator, __int128 low, __int128 high) {
  return 3 * low <= numerator && numerator < 3 * high;
}

void expect_barycenter_inside(const std::array<Point, 3>& t, const CubeId& cube, int root_bits) {
  const auto side = static_cast<__int128>(cube.side(root_bits));
  const std::array<std::int32_t, 3> index{cube.x, cube.y, cube.z};
  for (int axis = 0; axis < 3; ++axis) {
    const __int128 low = side * index[static_cast<std::size_t>(axis)];
    const __int128 sum = static_cast<__int128>(t[0][axis]) + t[1][axis] + t[2][axis];
    EXPECT_TRUE(third_lies_in(sum, low, low + side)) << "axis " << axis;
  }
}

TEST(Octree, BarycenterLiesInItsCube) {
  std::uint64_t seed = 0;
  for_all_lattices([&](int root_bits, int level) {
    Random random(++seed);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << root_bits << " bits, level " << level);
    const std::int64_t root = std::int64_t{1} << root_bits;
    for (int round = 0; round < 40; ++round) {
      std::array<Point, 3> t;
      for (Point& p : t) p = {pick(random, 0, root), pick(random, 0, root), pick(random, 0, root)};
      if (t[0] == t[1] && t[1] == t[2]) continue;
      const CubeId cube = cube_of_barycenter(t[0], t[1], t[2], level, root_bits);
      EXPECT_EQ(cube.level, level);
      expect_barycenter_inside(t, cube, root_bits);
      EXPECT_EQ(cube, cube_of_barycenter(t[2], t[0], t[1], level, root_bits));
      EXPECT_EQ(cube, cube_of_barycenter(t[1], t[0], t[2], level, root_bits));
      // The grids are nested: the cube of a coarser level is an ancestor, wherever the corners lie.
      if (level > 0) {
        EXPECT_EQ(cube.parent(), cube_of_barycenter(t[0], t[1], t[2], level - 1, root_bits));
      }
    }
  });
}

// Sums one below, at and one above a cube's border, where a rounded third would be wrong; corners far away.
TEST(Octree, BarycenterOnABorderBelongsToTheUpperCube) {
  std::uint64_t seed = 1000;
  for_all_lattices([&](int root_bits, int level) {
    Random random(++seed);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << root_bits << " bits, level " << level);
    for (int round = 0; round < 20; ++round) {
      const CubeId cube = random_cube(random, level);
      const Point low = cube.corner(root_bits);
      std::array<std::int32_t, 3> expected{cube.x, cube.y, cube.z};
      std::array<Point, 3> t;
      for (int axis = 0; axis < 3; ++axis) {
        const std::int32_t away = pick(random, -(1 << 28), 1 << 28);
        const std::int32_t shift = pick(random, -1, 1);
        t[0][axis] = low[axis] + away;
        t[1][axis] = low[axis] - 2 * away;
        t[2][axis] = low[axis] + away + shift;
        if (shift < 0) --expected[static_cast<std::size_t>(axis)];
      }
      EXPECT_EQ(cube_of_barycenter(t[0], t[1], t[2], level, root_bits),
                (CubeId{level, expected[0], expected[1], expected[2]}));
    }
  });
}

TEST(Octree, BarycenterOfTheFarthestPointsDoesNotOverflow) {
  constexpr std::int32_t kLow = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kHigh = std::numeric_limits<std::int32_t>::max();
  for_all_lattices([&](int root_bits, int level) {
    for (const std::int32_t value : {kLow, kHigh}) {
      const std::array<Point, 3> t{Point{value, value, value}, Point{value, value, value},
                                   Point{value, value, value}};
      const CubeId cube = cube_of_barycenter(t[0], t[1], t[2], level, root_bits);
      expect_barycenter_inside(t, cube, root_bits);
      EXPECT_FALSE(cube.is_inside_root());
    }
  });
}

TEST(Octree, ParentsChildrenAndCentersAgree) {
  std::uint64_t seed = 2000;
  for_all_lattices([&](int root_bits, int level) {
    Random random(++seed);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << root_bits << " bits, level " << level);
    for (int round = 0; round < 20; ++round) {
      const CubeId cube = random_cube(random, level);
      EXPECT_TRUE(cube.is_inside_root());
      const Point center = cube.center(root_bits);
      EXPECT_EQ(cube_at(center, level, root_bits), cube);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(2 * (std::int64_t{center[axis]} - cube.corner(root_bits)[axis]), cube.side(root_bits));
        Point other = center;
        ++other[axis];
        EXPECT_FALSE(cube_at(other, level, root_bits).is_inside_root());
      }
      if (level > 0) {
        EXPECT_FALSE(cube_at(center, level - 1, root_bits).is_inside_root());
      }
      EXPECT_FALSE(cube_at(center, level + 1, root_bits).is_inside_root());
      if (level == kMaxCubeLevel || level + 1 == root_bits) continue;
      for (int octant = 0; octant < 8; ++octant) {
        const CubeId child = cube.child(octant);
        EXPECT_TRUE(child.is_inside_root());
        EXPECT_EQ(child.parent(), cube);
        EXPECT_TRUE(cube.contains(child.corner(root_bits), root_bits));
        for (int axis = 0; axis < 3; ++axis)
          EXPECT_EQ(child.center(root_bits)[axis] > center[axis], (octant >> axis & 1) == 1);
      }
    }
  });
}

TEST(Octree, NoCubeHasACenterOutsideTheRootOrAnUnknownLevel) {
  const Point center{1 << 29, 1 << 29, 1 << 29};
  EXPECT_TRUE(cube_at(center, 0, 30).is_inside_root());
  for (const int level : {-1, kMaxCubeLevel + 1, 30, 31, 32, 64, std::numeric_limits<int>::max()})
    EXPECT_FALSE(cube_at(center, level, 30).is_inside_root()) << level;
  EXPECT_FALSE(cube_at({-(1 << 29), 1 << 29, 1 << 29}, 0, 30).is_inside_root());
  EXPECT_FALSE(cube_at({3 * (1 << 29), 1 << 29, 1 << 29}, 0, 30).is_inside_root());
  for (const std::int32_t index : {-1, 8})
    for (int axis = 0; axis < 3; ++axis) {
      Point outside{3, 3, 3};
      outside[axis] = index;
      EXPECT_FALSE((CubeId{3, outside.x, outside.y, outside.z}.is_inside_root()));
    }
  EXPECT_FALSE((CubeId{-1, 0, 0, 0}.is_inside_root()));
}

// Every cube of a level, and a margin around the root, is in the one block that its indices name.
TEST(Octree, EveryCubeIsInExactlyOneBlock) {
  for (const int n : {4, 8, 12, 64})
    for (int x = -2 * n; x <= 3 * n; ++x) {
      int count = 0;
      for (int b = -4; b <= 5; ++b)
        if (n * b - n / 2 <= x && x <= n * b + n / 2 - 1) {
          ++count;
          for (int axis = 0; axis < 3; ++axis) {
            Point cube{1, 1, 1};
            Point block{0, 0, 0};
            cube[axis] = x;
            block[axis] = b;
            EXPECT_EQ(block_of({7, cube.x, cube.y, cube.z}, n), (BlockId{7, block.x, block.y, block.z}));
          }
        }
      EXPECT_EQ(count, 1) << n << ' ' << x;
    }
}

TEST(Octree, RootIsTheOnlyBlockOfLevel0) {
  for (int n = kLeastBlockSize; n <= kGreatestBlockSize; n += 4)
    EXPECT_EQ(block_of(CubeId{}, n), (BlockId{0, 0, 0, 0}));
}

TEST(Octree, ChildrenOfOneParentAreInOneBlock) {
  for (const int n : {4, 8, 12})
    for (int level = 0; level < kMaxCubeLevel; ++level) {
      const std::uint64_t seed = static_cast<std::uint64_t>(100 * n + level);
      Random random(seed);
      for (int round = 0; round < 50; ++round) {
        const CubeId parent = random_cube(random, level);
        for (int octant = 1; octant < 8; ++octant)
          EXPECT_EQ(block_of(parent.child(octant), n), block_of(parent.child(0), n)) << "seed " << seed;
      }
    }
}

// Cubes on the two sides of a block's border have parents in one block, and so have those one parent farther.
TEST(Octree, BlockBordersAreInteriorAtTheNextCoarserLevel) {
  for (const int n : {4, 8, 12})
    for (int level = 1; level <= 6; ++level)
      for (int axis = 0; axis < 3; ++axis)
        for (int x = 1; x < 1 << level; ++x) {
          Point at{0, 0, 0};
          at[axis] = x;
          const CubeId cube{level, at.x, at.y, at.z};
          at[axis] = x - 1;
          const CubeId below{level, at.x, at.y, at.z};
          if (block_of(cube, n) == block_of(below, n)) continue;
          EXPECT_EQ(block_of(cube.parent(), n), block_of(below.parent(), n)) << n << ' ' << level << ' ' << x;
          // n / 4 cubes of the coarser level lie between this border and that of its block, on either side.
          const BlockId coarse = block_of(cube.parent(), n);
          const Point index{cube.parent().x, cube.parent().y, cube.parent().z};
          for (int step = -n / 4; step < n / 4; ++step) {
            Point near = index;
            near[axis] += step;
            EXPECT_EQ(block_of({level - 1, near.x, near.y, near.z}, n), coarse);
          }
        }
}

TEST(Octree, BordersOfUnshiftedBlocksAreBordersOfFinerOnes) {
  for (const int n : {4, 8, 12})
    for (int level = 0; level <= 6; ++level)
      for (int x = 0; x < 1 << level; ++x) {
        EXPECT_EQ(unshifted_block_of({level, 0, x, 0}, n), (BlockId{level, 0, x / n, 0}));
        if (level == 0 || x == 0) continue;
        const CubeId cube{level, x, 0, 0}, below{level, x - 1, 0, 0};
        if (unshifted_block_of(cube.parent(), n) != unshifted_block_of(below.parent(), n)) {
          EXPECT_NE(unshifted_block_of(cube, n), unshifted_block_of(below, n))
              << n << ' ' << level << ' ' << x;
        }
      }
}

TEST(Octree, TouchesMeansAChebyshevDistanceOfAtMostOne) {
  std::uint64_t seed = 3000;
  for (const int n : {4, 8}) {
    for (int round = 0; round < 300; ++round) {
      Random random(++seed);
      const BlockId block{6, pick(random, -1, 3), pick(random, -1, 3), pick(random, -1, 3)};
      const auto near = [&](std::int32_t b) { return pick(random, n * b - n / 2 - 3, n * b + n / 2 + 2); };
      const CubeId cube{6, near(block.x), near(block.y), near(block.z)};
      std::int64_t distance = std::numeric_limits<std::int64_t>::max();
      for (int dz = -n / 2; dz < n / 2; ++dz)
        for (int dy = -n / 2; dy < n / 2; ++dy)
          for (int dx = -n / 2; dx < n / 2; ++dx) {
            const CubeId of_block{6, n * block.x + dx, n * block.y + dy, n * block.z + dz};
            ASSERT_EQ(block_of(of_block, n), block);
            distance = std::min(distance,
                                max_distance({of_block.x, of_block.y, of_block.z}, {cube.x, cube.y, cube.z}));
          }
      EXPECT_EQ(touches(block, n, cube), distance <= 1) << "seed " << seed;
      EXPECT_FALSE(touches(block, n, {5, cube.x, cube.y, cube.z})) << "another level";
    }
  }
}

TEST(Octree, MaxDistanceIsTheLargestDifference) {
  constexpr std::int32_t kLow = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kHigh = std::numeric_limits<std::int32_t>::max();
  EXPECT_EQ(max_distance({1, 2, 3}, {1, 2, 3}), 0);
  EXPECT_EQ(max_distance({1, 2, 3}, {4, 2, 1}), 3);
  EXPECT_EQ(max_distance({1, -2, 3}, {1, 5, 1}), 7);
  EXPECT_EQ(max_distance({1, 2, 3}, {1, 2, -8}), 11);
  EXPECT_EQ(max_distance({kLow, 0, 0}, {kHigh, 0, 0}), (std::int64_t{1} << 32) - 1);
}

TEST(Octree, NeighbouringCubesHaveDifferentHashes) {
  std::unordered_set<std::size_t> hashes;
  for (int level = 5; level < 7; ++level)
    for (int x = 0; x < 32; ++x)
      for (int y = 0; y < 32; ++y)
        for (int z = 0; z < 32; ++z) hashes.insert(CubeIdHash{}({level, x, y, z}));
  EXPECT_EQ(hashes.size(), 2U * 32 * 32 * 32);
}

}  // namespace
}  // namespace colossus::hierarchy
