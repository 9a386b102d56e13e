// What the two kinds of positions are made of.
#include <gtest/gtest.h>

#include "codec/coded/lattice_node.hpp"
#include "codec/coded/weights.hpp"

namespace colossus::codec::coded {
namespace {

using geometry::Point;

TEST(LatticeNode, KeepsPositionsAgainstTheLeastOfEachCoordinate) {
  const std::vector<Point> positions{{-5, 7, 1 << 30}, {3, 6, 1 << 30}, {-4, 1000, 1 << 30}};
  CodedNode node = lattice_node();
  set_lattice_positions(node, positions);
  EXPECT_TRUE(node.is_on_lattice());
  EXPECT_EQ(node.offset, (Point{-5, 6, 1 << 30}));
  EXPECT_EQ(node.position_bits, 10);  // 994 along y
  EXPECT_EQ(node.parts[0].positions, (std::vector<Coordinates>{{0, 1, 0, 0}, {8, 0, 0, 0}, {1, 994, 0, 0}}));
  EXPECT_EQ(lattice_positions(node), positions);
  EXPECT_EQ(lattice_position(node, 2), positions[2]);
  set_lattice_positions(node, {});
  EXPECT_EQ(node, lattice_node());
}

TEST(LatticeNode, HoldsTheWholeRangeOfACoordinate) {
  const std::vector<Point> positions{{INT32_MIN, INT32_MAX, 0}, {INT32_MAX, INT32_MIN, 0}};
  CodedNode node = lattice_node();
  set_lattice_positions(node, positions);
  EXPECT_EQ(node.position_bits, 32);
  EXPECT_EQ(lattice_positions(node), positions);
}

TEST(Weights, AreMarkedWhereTheyAreZero) {
  EXPECT_EQ(marks_of(Weights{1, 2, 3, 4}), 0);
  EXPECT_EQ(marks_of(Weights{0, 2, 0, 4}), 5);
  EXPECT_EQ(marks_of(std::vector<Weights>{{0, 0, 0, 16}, {1, 2, 3, 10}, {4, 4, 8, 0}}),
            (std::vector<std::uint8_t>{7, 0, 8}));
}

TEST(CodedNode, TakesTheMemoryOfItsArrays) {
  CodedNode node;
  EXPECT_EQ(memory_bytes(node), sizeof(CodedNode));
  node.parts.resize(2);
  for (CodedPart& part : node.parts) {
    part.positions.resize(10);
    part.normals.resize(10);
    part.colors.resize(10);
    part.parents.resize(10);
    part.triangles.resize(7);
  }
  EXPECT_EQ(memory_bytes(node), sizeof(CodedNode) + 2 * (sizeof(CodedPart) + 10 * (16 + 2 + 4 + 4) + 7 * 12));
}

}  // namespace
}  // namespace colossus::codec::coded
