#include "codec/cube_codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <string>

#include "codec/allocation_count.hpp"
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

CubeMesh random_cube(Random& random, const Shape& shape) {
  CubeMesh cube;
  cube.has_normals = (shape.flags & 1) != 0;
  cube.has_colors = (shape.flags & 2) != 0;
  cube.has_parents = (shape.flags & 4) != 0;
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
    cube.positions.push_back(p);
    if (cube.has_normals) cube.normals.push_back({random_byte(random), random_byte(random)});
    if (cube.has_colors)
      cube.colors.push_back(
          {random_byte(random), random_byte(random), random_byte(random), random_byte(random)});
    if (cube.has_parents)
      cube.parents.push_back(v == 0 ? shape.greatest_parent
                                    : static_cast<std::uint32_t>(pick(random, 0, shape.greatest_parent)));
  }
  cube.triangles = random_triangles(random, shape.used);
  return cube;
}

void expect_round_trip(const CubeMesh& cube) {
  const auto decoded = decode_cube(encode(cube));
  ASSERT_TRUE(decoded) << decoded.defect().message << " at " << decoded.defect().offset;
  EXPECT_TRUE(decoded.value() == cube);
}

TEST(CubeCodec, DecodesWhatItEncoded) {
  std::uint64_t seed = 100;
  for (int width = 0; width <= 32; ++width)
    for (int flags = 0; flags < 8; ++flags)
      for (int round = 0; round < 4; ++round) {
        Random random(++seed);
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", width " << width << ", flags " << flags);
        expect_round_trip(random_cube(random, {flags, static_cast<std::uint32_t>(pick(random, 0, 100)),
                                               static_cast<std::uint32_t>(pick(random, 0, 20)), width,
                                               static_cast<std::uint32_t>(pick(random, 0, 100000))}));
      }
}

// Where the sizes of an index and of a parent's index change.
TEST(CubeCodec, DecodesAnyNumberOfVerticesAndAnyParent) {
  for (const std::uint32_t count : {0U, 1U, 2U, 254U, 255U, 256U, 257U, 65534U, 65535U, 65536U, 65537U})
    for (const std::uint32_t unused : {0U, 1U, 300U}) {
      constexpr std::uint64_t kSeed = 1;
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", vertices " << count << " + " << unused);
      Random random(kSeed);
      expect_round_trip(random_cube(random, {0, count, unused}));
    }
  for (const std::uint32_t parent : {0U, 255U, 256U, 65535U, 65536U, 0xffffffffU}) {
    Random random(2);
    expect_round_trip(random_cube(random, {4, 10, 2, 12, parent}));
  }
}

TEST(CubeCodec, KeepsTheFarthestCoordinates) {
  CubeMesh cube;
  cube.positions = {{kLeast, 0, kGreatest}, {kGreatest, kLeast, 0}, {0, kGreatest, kLeast}};
  cube.triangles = {{0, 1, 2}};
  expect_round_trip(cube);
  cube.positions = {{kGreatest, kGreatest, kGreatest}, {kGreatest, kGreatest, kGreatest}};
  cube.triangles.clear();
  expect_round_trip(cube);
}

TEST(CubeCodec, RefusesAnyOtherLength) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    core::Bytes bytes =
        encode(random_cube(random, {static_cast<int>(seed % 8), 20, 3, static_cast<int>(seed)}));
    for (std::size_t size = 0; size < bytes.size(); ++size)
      EXPECT_FALSE(decode_cube(std::span(bytes).first(size))) << "cut to " << size << " of " << bytes.size();
    bytes.push_back(std::byte{0});
    EXPECT_FALSE(decode_cube(bytes));
  }
}

void expect_valid(const CubeMesh& cube) {
  const std::size_t count = cube.positions.size();
  for (const Point& p : cube.positions)
    for (int axis = 0; axis < 3; ++axis) EXPECT_GE(p[axis], kLeast);
  EXPECT_EQ(cube.normals.size(), cube.has_normals ? count : 0);
  EXPECT_EQ(cube.colors.size(), cube.has_colors ? count : 0);
  EXPECT_EQ(cube.parents.size(), cube.has_parents ? count : 0);
  std::uint32_t next = 0;
  for (const Triangle& t : cube.triangles)
    for (const std::uint32_t v : t) {
      EXPECT_LT(v, count);
      EXPECT_LE(v, next);
      next += v == next ? 1 : 0;
    }
}

TEST(CubeCodec, AnyFlippedBitIsRefusedOrAnotherValidCube) {
  std::size_t refused = 0;
  std::size_t accepted = 0;
  for (std::uint64_t seed = 1; seed <= 64; ++seed) {
    Random random(seed);
    const CubeMesh cube =
        random_cube(random, {static_cast<int>(seed % 8), static_cast<std::uint32_t>(seed % 7),
                             static_cast<std::uint32_t>(seed % 3), static_cast<int>(seed % 33)});
    const core::Bytes original = encode(cube);
    for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", bit " << bit);
      core::Bytes bytes = original;
      bytes[bit / 8] ^= std::byte{1} << bit % 8;
      const auto decoded = decode_cube(bytes);
      ++(decoded ? accepted : refused);
      if (!decoded) continue;
      expect_valid(decoded.value());
      EXPECT_FALSE(decoded.value() == cube);
      EXPECT_EQ(encode(decoded.value()), bytes);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(refused, 1000U);
  EXPECT_GT(accepted, 1000U);
}

core::Bytes header(std::uint8_t width, std::uint32_t vertices, std::uint32_t triangles, const Point& offset) {
  core::ByteWriter writer;
  writer.put(std::array<std::uint8_t, 5>{2, 1, 0, width, 0});
  writer.put(vertices);
  writer.put(triangles);
  for (int axis = 0; axis < 3; ++axis) writer.put(offset[axis]);
  return writer.take();
}

std::string defect_of(const core::Bytes& bytes) {
  const auto decoded = decode_cube(bytes);
  return decoded ? "none" : decoded.defect().message;
}

TEST(CubeCodec, RefusesCoordinatesOutOfRange) {
  const auto one_point = [](std::int32_t low, std::uint8_t up) {
    core::Bytes bytes = header(up == 0 ? 0 : 1, 2, 0, {low, low, low});
    for (int axis = 0; axis < 3; ++axis) {
      bytes.push_back(std::byte{0});
      bytes.push_back(std::byte{up});
    }
    return bytes;
  };
  EXPECT_EQ(defect_of(one_point(kLeast, 1)), "none");
  EXPECT_EQ(defect_of(one_point(kLeast - 1, 1)), "the offset is out of range");
  EXPECT_EQ(defect_of(one_point(kGreatest - 1, 1)), "none");
  EXPECT_EQ(defect_of(one_point(kGreatest, 0)), "none");
  EXPECT_EQ(defect_of(one_point(kGreatest, 1)), "a coordinate is out of range");
}

TEST(CubeCodec, RefusesAnotherEncodingOfTheSameCube) {
  EXPECT_EQ(defect_of(header(0, 0, 0, {0, 0, 0})), "none");
  EXPECT_EQ(defect_of(header(1, 0, 0, {0, 0, 0})), "the width is not that of the widest axis");
  EXPECT_EQ(defect_of(header(0, 0, 0, {0, 5, 0})), "the offset is not the least coordinate");
  EXPECT_EQ(defect_of(header(33, 0, 0, {0, 0, 0})), "a coordinate is wider than 32 bits");
}

TEST(CubeCodec, RefusesParentsThatAreWiderThanTheyNeedToBe) {
  const auto one_vertex = [](std::uint8_t parent_bytes, std::uint32_t parent) {
    core::Bytes bytes = header(0, 1, 0, {0, 0, 0});
    bytes[2] = std::byte{4};
    bytes[4] = std::byte{parent_bytes};
    bytes.resize(bytes.size() + 3);
    for (int i = 0; i < parent_bytes; ++i) bytes.push_back(static_cast<std::byte>(parent >> 8 * i));
    return bytes;
  };
  const std::string refused = "parent indices are wider than they need to be";
  EXPECT_EQ(defect_of(one_vertex(1, 255)), "none");
  EXPECT_EQ(defect_of(one_vertex(2, 255)), refused);
  EXPECT_EQ(defect_of(one_vertex(2, 256)), "none");
  EXPECT_EQ(defect_of(one_vertex(4, 65535)), refused);
  EXPECT_EQ(defect_of(one_vertex(4, 65536)), "none");
  EXPECT_EQ(defect_of(one_vertex(3, 65536)), "the size of parent indices is out of range");
  EXPECT_EQ(defect_of(one_vertex(0, 0)), "the size of parent indices is out of range");
}

TEST(CubeCodec, RefusesTrianglesWithoutVertices) {
  core::Bytes bytes = header(0, 0, 1, {0, 0, 0});
  bytes.resize(bytes.size() + 3);
  EXPECT_EQ(defect_of(bytes), "a vertex index is out of range");
}

// Counts that the bytes cannot hold, whatever the other fields say, and the most that any bytes decode to.
TEST(CubeCodec, AllocatesNoMoreThanASmallMultipleOfItsInput) {
  constexpr std::uint32_t kMany = 0xffffffff;
  for (const int width : {0, 1, 8, 32})
    for (const auto& [vertices, triangles] :
         {std::pair{kMany, 0U}, {0U, kMany}, {kMany, kMany}, {1U << 20, 1U << 20}}) {
      core::Bytes bytes = header(static_cast<std::uint8_t>(width), vertices, triangles, {0, 0, 0});
      bytes.resize(bytes.size() + 64);
      const std::size_t before = allocated_bytes();
      EXPECT_EQ(defect_of(bytes), "the cube is cut short");
      EXPECT_LT(allocated_bytes() - before, 10 * bytes.size());
    }
  Random random(7);
  for (int flags = 0; flags < 8; ++flags) {
    CubeMesh cube = random_cube(random, {flags, 250, 0, 0, 0});
    const core::Bytes bytes = encode(cube);
    const std::size_t before = allocated_bytes();
    EXPECT_TRUE(decode_cube(bytes));
    EXPECT_LT(allocated_bytes() - before, 5 * bytes.size());
  }
}

TEST(CubeCodecDeathTest, RefusesToEncodeWhatItCouldNotDecode) {
  CubeMesh cube;
  cube.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  cube.triangles = {{0, 2, 1}};
  EXPECT_DEATH(encode(cube), "order of first use");
  cube.triangles = {{0, 1, 2}, {1, 2, 3}};
  EXPECT_DEATH(encode(cube), "vertex 3 of 3");
  cube.triangles.clear();
  cube.positions[1].y = kLeast - 1;
  EXPECT_DEATH(encode(cube), "position");
  cube.positions[1].y = 0;
  cube.has_parents = true;
  EXPECT_DEATH(encode(cube), "0 parents");
}

// A change of these bytes is a new version of the format, in schemas/ too.
TEST(CubeCodec, BytesOfVersion1StayAsTheyAre) {
  CubeMesh cube{true, true, true, {}, {}, {}, {}, {}};
  cube.positions = {
      {-5, 100, 1 << 29}, {0, 101, (1 << 29) + 300}, {70, 90, (1 << 29) + 2}, {1, 2000, 1 << 29}};
  cube.normals = {{1, 2}, {128, 255}, {0, 7}, {64, 64}};
  cube.colors = {{1, 2, 3, 4}, {255, 254, 253, 252}, {10, 20, 30, 40}, {0, 0, 0, 255}};
  cube.parents = {0, 300, 2, 2};
  cube.triangles = {{0, 1, 2}, {1, 0, 2}};
  const core::Bytes bytes = encode(cube);
  EXPECT_EQ(bytes.size(), 25U + 4U * (3U * 2U + 2U + 4U + 2U) + 6U);
  EXPECT_EQ(core::hash64(bytes), 0xdff62eb80df9437bULL);
  const auto decoded = decode_cube(bytes);
  ASSERT_TRUE(decoded) << decoded.defect().message;
  EXPECT_TRUE(decoded.value() == cube);
}

}  // namespace
}  // namespace colossus::codec
