#include "hierarchy/diamond.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace colossus::hierarchy {
namespace {

std::vector<Tetrahedron> roots() {
  const Diamond root = Diamond::at(root_center());
  return {root.tetrahedra.begin(), root.tetrahedra.begin() + root.place_count};
}

TEST(Diamond, RootHasTheSixKuhnTetrahedraAndNoParents) {
  const Diamond root = Diamond::at(root_center());
  EXPECT_EQ(root.level, 0);
  EXPECT_EQ(root.place_count, 6);
  EXPECT_TRUE(root.parents().empty());
  for (const Tetrahedron& t : roots()) {
    EXPECT_EQ(t.corners[0], (Point{0, 0, 0}));
    EXPECT_EQ(t.corners[3], (Point{geometry::kRootSide, geometry::kRootSide, geometry::kRootSide}));
  }
}

// Bisecting everything, level by level, gives exactly the diamonds that the index arithmetic names, complete
// inside the root cube, and every tetrahedron's parent is among its diamond's parents.
TEST(Diamond, BisectionAndIndexArithmeticAgree) {
  std::vector<Tetrahedron> level = roots();
  for (int l = 0; l < 10; ++l) {
    std::map<Point, std::set<int>> places;
    for (const Tetrahedron& t : level) {
      const Diamond diamond = Diamond::at(t.center());
      ASSERT_EQ(diamond.level, l);
      ASSERT_TRUE(places[t.center()].insert(diamond.place_of(t)).second);
      ASSERT_EQ(tetrahedron_of(id_of(t)), t);
    }
    for (const auto& [center, found] : places) {
      const Diamond diamond = Diamond::at(center);
      ASSERT_EQ(diamond.place_count, l % 3 == 0 ? 6 : l % 3 == 1 ? 4 : 8);
      for (int i = 0; i < diamond.place_count; ++i)
        ASSERT_EQ(diamond.is_inside[static_cast<std::size_t>(i)], found.contains(i));
    }
    std::vector<Tetrahedron> next;
    for (const Tetrahedron& t : level)
      for (const int end : {0, 1}) {
        const Tetrahedron half = t.child(end);
        const auto parents = Diamond::at(half.center()).parents();
        ASSERT_TRUE(std::find(parents.begin(), parents.end(), t.center()) != parents.end());
        const Plane plane = t.bisector();
        for (const Point& corner : half.corners) ASSERT_GE(plane.side(corner) * (end == 0 ? 1 : -1), 0);
        next.push_back(half);
      }
    level = std::move(next);
  }
}

TEST(Diamond, InputVerticesLieOnNoPlane) {
  std::mt19937 random(7);
  std::vector<Tetrahedron> chain = roots();
  for (int round = 0; round < 200; ++round) {
    Point p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = static_cast<std::int32_t>(random() % ((1U << 27) - 2) + 1) * 8 + (1 << axis);
    int containing = 0;
    Tetrahedron t{};
    for (const Tetrahedron& root : roots())
      if (root.contains(p)) {
        ++containing;
        t = root;
      }
    ASSERT_EQ(containing, 1);
    for (int level = 0; level < kMaxLevel; ++level) {
      const std::int64_t side = t.bisector().side(p);
      ASSERT_NE(side, 0);
      t = t.child(side > 0 ? 0 : 1);
      ASSERT_TRUE(t.contains(p));
    }
  }
}

TEST(Diamond, ParentsAreOneLevelCoarserAndAtMostFour) {
  std::mt19937 random(11);
  for (int round = 0; round < 500; ++round) {
    Tetrahedron t = roots()[random() % 6];
    const auto depth = random() % 40;
    for (std::size_t i = 0; i < depth; ++i) t = t.child(static_cast<int>(random() % 2));
    const Diamond diamond = Diamond::at(t.center());
    const auto parents = diamond.parents();
    const std::size_t most = diamond.level % 3 == 0 ? 3 : diamond.level % 3 == 1 ? 2 : 4;
    EXPECT_LE(parents.size(), most);
    EXPECT_EQ(parents.empty(), diamond.level == 0);
    for (const Point& parent : parents) EXPECT_EQ(level_of(parent), diamond.level - 1);
  }
}

}  // namespace
}  // namespace colossus::hierarchy
