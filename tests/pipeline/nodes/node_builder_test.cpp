#include "pipeline/nodes/node_builder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>

#include "codec/coded/lattice_node.hpp"
#include "codec/node_codec.hpp"
#include "container/chunk.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::nodes {
namespace {

using codec::coded::CodedNode;
using geometry::Point;

// A row of triangles through these points, in the codec's order.
CodedNode node_through(const std::vector<Point>& positions, const codec::Codec& codec) {
  CodedNode node = codec::coded::lattice_node();
  codec::coded::CodedPart& part = node.parts[0];
  for (std::uint32_t i = 0; i + 2 < positions.size(); ++i) part.triangles.push_back({i, i + 1, i + 2});
  set_lattice_positions(node, positions);
  codec::put_in_order(part, codec);
  return node;
}

std::vector<Point> random_points(std::mt19937& random, std::size_t count) {
  std::uniform_int_distribution<std::int32_t> coordinate(0, geometry::kRootSide);
  std::vector<Point> points(count);
  for (Point& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

// What a reader makes of a position.
double world_of(const StoredLattice& lattice, std::size_t axis, std::int64_t value) {
  return lattice.origin[axis] + lattice.step * static_cast<double>(value);
}

TEST(NodeBuilder, BoundsAreThoseOfWhatAReaderComputesToTheBit) {
  const CommonFolder folder;
  const TestBuild build(folder);
  const codec::Codec& codec = codec::codecs()[0];
  std::mt19937 random(test_seed());
  for (int round = 0; round < 50; ++round) {
    const std::vector<Point> points = random_points(random, 3 + random() % 30);
    // No power of two, and far away, so that every addition rounds.
    const StoredLattice lattice{{1e6 / 3.0, -1e7 / 7.0, 0.1}, 0.001 / 3.0};
    NodeBuilder builder(lattice, 3, {1, 2, 3}, {0, 0, 0});
    for (const Point& p : points) builder.add_position({p.x, p.y, p.z});
    const facts::FinishedNode node =
        std::move(builder).store(build.workspace(), node_through(points, codec), codec);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = INFINITY, high = -INFINITY;
      for (const Point& p : points) {
        low = std::min(low, world_of(lattice, axis, p[static_cast<int>(axis)]));
        high = std::max(high, world_of(lattice, axis, p[static_cast<int>(axis)]));
      }
      ASSERT_EQ(node.row.bounds[axis], low);
      ASSERT_EQ(node.row.bounds[axis + 3], high);
    }
  }
}

TEST(NodeBuilder, TheChunkInScratchIsTheMeshAndTheRowCountsIt) {
  const CommonFolder folder;
  const TestBuild build(folder);
  std::mt19937 random(test_seed());
  for (const codec::Codec& codec : codec::codecs()) {
    const std::vector<Point> points = random_points(random, 40);
    const CodedNode mesh = node_through(points, codec);
    NodeBuilder builder({{}, 1.0}, 5, {7, 8, 9}, {0, 0, 0});
    for (const Point& p : points) builder.add_position({p.x, p.y, p.z});
    builder.node().row.flags = container::kNodeIsLeaf;
    const facts::FinishedNode node = std::move(builder).store(build.workspace(), mesh, codec);
    EXPECT_EQ(node.row.level, 5U);
    EXPECT_EQ(node.row.center, (std::array<std::int32_t, 3>{7, 8, 9}));
    EXPECT_EQ(node.row.flags, container::kNodeIsLeaf);
    EXPECT_EQ(node.row.tetra_mask, 1);
    EXPECT_EQ(node.row.vertices, 40U);
    EXPECT_EQ(node.row.triangles, 38U);
    const core::Bytes frame = build.workspace().reader.read(node.chunk);
    EXPECT_EQ(frame.size(), node.row.stored_bytes);
    EXPECT_EQ(core::hash64(frame), node.row.checksum);
    const auto payload = container::unpack_chunk(frame, node.row.payload_bytes);
    ASSERT_TRUE(payload) << payload.defect().message;
    const auto decoded = codec::decode_on_lattice(payload.value(), {40, 38});
    ASSERT_TRUE(decoded) << decoded.defect().message;
    EXPECT_EQ(decoded.value(), mesh);
    EXPECT_EQ(node.chunk.file.stream, scratch::kKeptStream) << "it stays when phases are released";
    // Sections without the head before them and without the rest behind them.
    const codec::Payload encoded = codec::encode(mesh, codec);
    const container::PackedChunk packed =
        container::pack_chunk(encoded.bytes, {codec.zstd_level, encoded.cuts});
    EXPECT_EQ(frame, packed.frame) << "at the level of " << codec.name;
    for (std::size_t i = 0; i < node.component_bytes.size(); ++i)
      EXPECT_EQ(node.component_bytes[i], packed.piece_bytes[i + 1]);
  }
}

TEST(NodeBuilder, TheMaskHasABitForEveryPlace) {
  const CommonFolder folder;
  const TestBuild build(folder);
  const codec::Codec& codec = codec::codecs()[0];
  CodedNode mesh;
  mesh.position_bits = 12;
  for (const auto place : std::to_array<std::uint8_t>({1, 4, 7})) {
    codec::coded::CodedPart part;
    part.place = place;
    part.positions = {{4096, 0, 0, 0}, {0, 4096, 0, 0}, {0, 0, 4096, 0}};
    part.triangles = {{0, 1, 2}};
    codec::put_in_order(part, codec);
    mesh.parts.push_back(part);
  }
  NodeBuilder builder({{}, 1.0}, 1, {0, 0, 0}, {0, 0, 0});
  for (int i = 0; i < 9; ++i) builder.add_position({1, 2, 3});
  const facts::FinishedNode node = std::move(builder).store(build.workspace(), mesh, codec);
  EXPECT_EQ(node.row.tetra_mask, 0b1001'0010);
  EXPECT_EQ(node.row.vertices, 9U);
  EXPECT_EQ(node.row.triangles, 3U);
}

TEST(NodeBuilder, ANodeWithoutVerticesHasItsBoundsWhereItIs) {
  const CommonFolder folder;
  const TestBuild build(folder);
  NodeBuilder builder({{10.0, 20.0, 30.0}, 0.5}, 0, {1, 1, 1}, {2, 4, 6});
  const facts::FinishedNode node =
      std::move(builder).store(build.workspace(), codec::coded::lattice_node(), codec::codecs()[0]);
  EXPECT_EQ(node.row.bounds, (std::array<double, 6>{11.0, 22.0, 33.0, 11.0, 22.0, 33.0}));
  EXPECT_EQ(node.row.vertices, 0U);
}

TEST(NodeBuilder, AnglesOfSeveralMeshesAddUp) {
  NodeBuilder builder({{}, 1.0}, 0, {}, {});
  mesh::Mesh sliver;
  for (const Point& p : {Point{0, 0, 0}, Point{1000, 0, 0}, Point{1000, 10, 0}})
    sliver.vertices.push_back({p, {}, 0, {}});
  sliver.triangles = {{0, 1, 2}};
  builder.count_angles(sliver);
  builder.count_angles(sliver);
  EXPECT_EQ(builder.node().statistics.angles.below_5_degrees, 2U);
  EXPECT_EQ(builder.node().statistics.angles.below_15_degrees, 2U);
  EXPECT_EQ(builder.node().statistics.angles.below_30_degrees, 2U);
}

}  // namespace
}  // namespace colossus::pipeline::nodes
