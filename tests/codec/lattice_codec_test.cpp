#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "codec/allocation_count.hpp"
#include "codec/coded/lattice_node.hpp"
#include "codec/node_codec.hpp"
#include "core/hash.hpp"

namespace colossus::codec {
namespace {

using geometry::Point;
using mesh::Triangle;
using Random = std::mt19937_64;

constexpr std::int32_t kLeast = -(std::int32_t{1} << 30);
constexpr std::int32_t kGreatest = std::numeric_limits<std::int32_t>::max();

// Both ends included.
std::int64_t pick(Random& random, std::int64_t low, std::int64_t high) {
  return std::uniform_int_distribution<std::int64_t>(low, high)(random);
}

std::uint8_t random_byte(Random& random) { return static_cast<std::uint8_t>(pick(random, 0, 255)); }

struct Shape {
  int flags = 0;  // 1 normals, 2 colours, 4 parents
  std::uint32_t used = 0;
  std::uint32_t unused = 0;
  int width = 12;  // bits of the widest axis
  std::uint32_t greatest_parent = 1000;
};

std::vector<Triangle> random_triangles(Random& random, std::uint32_t used) {
  std::vector<Triangle> triangles;
  std::uint32_t next = 0;
  std::int64_t extra = used == 0 ? 0 : pick(random, 0, 30);  // triangles after the last new vertex
  while (next < used || extra > 0) {
    extra -= next == used ? 1 : 0;
    Triangle t{};
    for (auto& v : t) {
      v = next < used && pick(random, 0, 1) == 0
              ? next
              : static_cast<std::uint32_t>(pick(random, 0, next == used ? used - 1 : next));
      next += v == next ? 1 : 0;
    }
    triangles.push_back(t);
  }
  // The farthest that an index can be from the newest vertex.
  if (used > 0) triangles.push_back({0, used - 1, 0});
  return triangles;
}

coded::CodedNode random_node(Random& random, const Shape& shape) {
  coded::CodedNode node = coded::lattice_node();
  coded::CodedPart& cube = node.parts[0];
  std::vector<Point> positions;
  node.has_normals = (shape.flags & 1) != 0;
  node.has_colors = (shape.flags & 2) != 0;
  node.has_parents = (shape.flags & 4) != 0;
  const std::int64_t extent =
      std::min((std::int64_t{1} << shape.width) - 1, std::int64_t{kGreatest} - kLeast);
  Point low;
  for (int axis = 0; axis < 3; ++axis)
    low[axis] = static_cast<std::int32_t>(pick(random, kLeast, kGreatest - extent));
  for (std::uint32_t v = 0; v < shape.used + shape.unused; ++v) {
    Point p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = static_cast<std::int32_t>(low[axis] + (v == 0   ? 0
                                                       : v == 1 ? extent
                                                                : pick(random, 0, extent)));
    positions.push_back(p);
    if (node.has_normals) cube.normals.push_back({random_byte(random), random_byte(random)});
    if (node.has_colors)
      cube.colors.push_back(
          {random_byte(random), random_byte(random), random_byte(random), random_byte(random)});
    if (node.has_parents)
      cube.parents.push_back(v == 0 ? shape.greatest_parent
                                    : static_cast<std::uint32_t>(pick(random, 0, shape.greatest_parent)));
  }
  cube.triangles = random_triangles(random, shape.used);
  set_lattice_positions(node, positions);
  return node;
}

coded::CodedNode in_order(coded::CodedNode node, const Codec& codec) {
  put_in_order(node.parts[0], codec);
  return node;
}

core::Bytes bytes_of(const coded::CodedNode& node, const Codec& codec) {
  return encode(in_order(node, codec), codec).bytes;
}

// No test has more.
constexpr NodeCounts kMost{1000000, 1000000};

void expect_round_trip(const coded::CodedNode& node) {
  for (const Codec& codec : codecs()) {
    SCOPED_TRACE(codec.name);
    const coded::CodedNode ordered = in_order(node, codec);
    const auto decoded = decode_on_lattice(encode(ordered, codec).bytes, kMost);
    ASSERT_TRUE(decoded) << decoded.defect().message << " at " << decoded.defect().offset;
    EXPECT_TRUE(decoded.value() == ordered);
  }
}

TEST(LatticeCodec, DecodesWhatItEncoded) {
  std::uint64_t seed = 100;
  for (int width = 0; width <= 32; ++width)
    for (int flags = 0; flags < 8; ++flags)
      for (int round = 0; round < 4; ++round) {
        Random random(++seed);
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", width " << width << ", flags " << flags);
        expect_round_trip(random_node(random, {flags, static_cast<std::uint32_t>(pick(random, 0, 100)),
                                               static_cast<std::uint32_t>(pick(random, 0, 20)), width,
                                               static_cast<std::uint32_t>(pick(random, 0, 100000))}));
      }
}

// Where the sizes of an index and of a parent's index change.
TEST(LatticeCodec, DecodesAnyNumberOfVerticesAndAnyParent) {
  for (const std::uint32_t count : {0U, 1U, 2U, 254U, 255U, 256U, 257U, 65534U, 65535U, 65536U, 65537U})
    for (const std::uint32_t unused : {0U, 1U, 300U}) {
      constexpr std::uint64_t kSeed = 1;
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", vertices " << count << " + " << unused);
      Random random(kSeed);
      expect_round_trip(random_node(random, {0, count, unused}));
    }
  for (const std::uint32_t parent : {0U, 255U, 256U, 65535U, 65536U, 0xffffffffU}) {
    Random random(2);
    expect_round_trip(random_node(random, {4, 10, 2, 12, parent}));
  }
}

TEST(LatticeCodec, KeepsTheFarthestCoordinates) {
  coded::CodedNode node = coded::lattice_node();
  set_lattice_positions(
      node, std::array<Point, 3>{{{kLeast, 0, kGreatest}, {kGreatest, kLeast, 0}, {0, kGreatest, kLeast}}});
  node.parts[0].triangles = {{0, 1, 2}};
  expect_round_trip(node);
  set_lattice_positions(
      node, std::array<Point, 2>{{{kGreatest, kGreatest, kGreatest}, {kGreatest, kGreatest, kGreatest}}});
  node.parts[0].triangles.clear();
  expect_round_trip(node);
}

TEST(LatticeCodec, RefusesAnyOtherLength) {
  for (const Codec& codec : codecs())
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
      SCOPED_TRACE(testing::Message() << codec.name << ", seed " << seed);
      Random random(seed);
      core::Bytes bytes =
          bytes_of(random_node(random, {static_cast<int>(seed % 8), 20, 3, static_cast<int>(seed)}), codec);
      for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(decode_on_lattice(std::span(bytes).first(size), kMost))
            << "cut to " << size << " of " << bytes.size();
      bytes.push_back(std::byte{0});
      EXPECT_FALSE(decode_on_lattice(bytes, kMost));
    }
}

// Puts the right checksum at the end.
void seal(core::Bytes& bytes) {
  const std::size_t size = bytes.size() - sizeof(std::uint64_t);
  const std::uint64_t checksum = core::hash64(std::span(bytes).first(size));
  std::memcpy(bytes.data() + size, &checksum, sizeof checksum);
}

void expect_valid(const coded::CodedNode& node) {
  ASSERT_EQ(node.parts.size(), 1U);
  const coded::CodedPart& cube = node.parts[0];
  const std::size_t count = cube.positions.size();
  for (const Point& p : lattice_positions(node))
    for (int axis = 0; axis < 3; ++axis) EXPECT_GE(p[axis], kLeast);
  EXPECT_EQ(cube.normals.size(), node.has_normals ? count : 0);
  EXPECT_EQ(cube.colors.size(), node.has_colors ? count : 0);
  EXPECT_EQ(cube.parents.size(), node.has_parents ? count : 0);
  std::uint32_t next = 0;
  for (const Triangle& t : cube.triangles)
    for (const std::uint32_t v : t) {
      EXPECT_LT(v, count);
      EXPECT_LE(v, next);
      next += v == next ? 1 : 0;
    }
}

TEST(LatticeCodec, AnyFlippedBitUnderARightChecksumIsRefusedOrAValidCube) {
  for (const Codec& codec : codecs()) {
    std::size_t refused = 0;
    std::size_t accepted = 0;
    for (std::uint64_t seed = 1; seed <= 64; ++seed) {
      Random random(seed);
      const core::Bytes original =
          bytes_of(random_node(random, {static_cast<int>(seed % 8), static_cast<std::uint32_t>(seed % 7),
                                        static_cast<std::uint32_t>(seed % 3), static_cast<int>(seed % 33)}),
                   codec);
      for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
        SCOPED_TRACE(testing::Message() << codec.name << ", seed " << seed << ", bit " << bit);
        core::Bytes bytes = original;
        bytes[bit / 8] ^= std::byte{1} << bit % 8;
        EXPECT_FALSE(decode_on_lattice(bytes, {100, 200}));
        seal(bytes);
        const auto decoded = decode_on_lattice(bytes, {100, 200});
        ++(decoded ? accepted : refused);
        if (decoded) expect_valid(decoded.value());
        if (HasFailure()) return;
      }
    }
    EXPECT_GT(refused, 1000U) << codec.name;
    EXPECT_GT(accepted, 100U) << codec.name;
  }
}

std::string defect_of(const core::Bytes& bytes) {
  const auto decoded = decode_on_lattice(bytes, {100, 200});
  return decoded ? "none" : decoded.defect().message;
}

coded::CodedNode two_points(const Point& offset, std::uint32_t up, int bits) {
  coded::CodedNode node = coded::lattice_node();
  node.offset = offset;
  node.position_bits = bits;
  node.parts[0].positions = {{0, 0, 0, 0}, {up, up, up, 0}};
  return node;
}

TEST(LatticeCodec, RefusesCoordinatesOutOfRange) {
  for (const Codec& codec : codecs()) {
    const auto defect = [&](std::int32_t low, std::uint32_t up) {
      return defect_of(to_payload(two_points({low, low, low}, up, up == 0 ? 0 : 1), codec).bytes);
    };
    EXPECT_EQ(defect(kLeast, 1), "none");
    EXPECT_EQ(defect(kLeast - 1, 1), "the offset is out of range");
    EXPECT_EQ(defect(kGreatest - 1, 1), "none");
    EXPECT_EQ(defect(kGreatest, 0), "none");
    EXPECT_EQ(defect(kGreatest, 1), "a coordinate is out of range");
  }
}

TEST(LatticeCodec, RefusesAnotherEncodingOfTheSameCube) {
  for (const Codec& codec : codecs()) {
    EXPECT_EQ(defect_of(to_payload(two_points({0, 0, 0}, 1, 1), codec).bytes), "none");
    EXPECT_EQ(defect_of(to_payload(two_points({0, 0, 0}, 1, 2), codec).bytes),
              "the position bits are not those of the widest axis");
    coded::CodedNode node = two_points({0, 0, 0}, 1, 1);
    node.parts[0].positions[0] = node.parts[0].positions[1];
    EXPECT_EQ(defect_of(to_payload(node, codec).bytes), "the offset is not the least coordinate");
  }
}

TEST(LatticeCodec, RefusesEarlierVersionsWithAClearWord) {
  for (const int scheme : {1, 2}) {
    core::Bytes bytes(100);
    bytes[0] = static_cast<std::byte>(scheme);
    bytes[1] = std::byte{1};
    EXPECT_NE(defect_of(bytes).find("early containers"), std::string::npos) << defect_of(bytes);
  }
  EXPECT_NE(defect_of(core::Bytes(100, std::byte{200})).find("unknown"), std::string::npos);
}

// Counts that the node table does not know allocate nothing; what decodes takes a small multiple of the
// result, and some tables.
TEST(LatticeCodec, AllocatesNoMoreThanASmallMultipleOfItsResult) {
  Random random(7);
  for (const Codec& codec : codecs())
    for (int flags = 0; flags < 8; ++flags) {
      const core::Bytes bytes = bytes_of(random_node(random, {flags, 250, 0, 0, 0}), codec);
      std::size_t before = allocated_bytes();
      EXPECT_TRUE(decode_on_lattice(bytes, kMost));
      EXPECT_LT(allocated_bytes() - before, 250000U) << codec.name << ", flags " << flags;
      core::Bytes large = bytes;
      std::memset(large.data() + 9, 0xff, 8);  // vertices and triangles of the one part
      seal(large);
      before = allocated_bytes();
      EXPECT_FALSE(decode_on_lattice(large, {250, 1000}));
      EXPECT_LT(allocated_bytes() - before, 10000U) << codec.name << ", flags " << flags;
    }
}

TEST(LatticeCodecDeathTest, RefusesToEncodeWhatItCouldNotDecode) {
  const Codec& zstd = codec_named("zstd");
  coded::CodedNode node = coded::lattice_node();
  std::vector<mesh::Triangle>& triangles = node.parts[0].triangles;
  std::vector<Point> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  set_lattice_positions(node, positions);
  triangles = {{0, 2, 1}};
  EXPECT_DEATH(encode(node, zstd), "order of first use");
  triangles = {{0, 1, 2}, {1, 2, 3}};
  EXPECT_DEATH(encode(node, zstd), "vertex 3 of 3");
  triangles.clear();
  ++node.position_bits;
  EXPECT_DEATH(encode(node, zstd), "position bits");
  positions[1].y = kLeast - 1;
  set_lattice_positions(node, positions);
  EXPECT_DEATH(encode(node, zstd), "the offset is out of range");
  positions[1].y = 0;
  set_lattice_positions(node, positions);
  node.has_parents = true;
  EXPECT_DEATH(encode(node, zstd), "0 parents");
  node.has_parents = false;
  node.parts.resize(2);
  EXPECT_DEATH(encode(node, zstd), "2 parts");
}

}  // namespace
}  // namespace colossus::codec
