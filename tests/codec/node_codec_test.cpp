#include "codec/node_codec.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "codec/coded/lattice_node.hpp"
#include "codec/coded/renumber.hpp"
#include "codec/coded/weights.hpp"
#include "core/hash.hpp"

namespace colossus::codec {
namespace {

using mesh::Triangle;
using Random = std::mt19937_64;

// Both ends included.
std::uint32_t pick(Random& random, std::uint32_t low, std::uint32_t high) {
  return std::uniform_int_distribution<std::uint32_t>(low, high)(random);
}

std::uint8_t random_byte(Random& random) { return static_cast<std::uint8_t>(pick(random, 0, 255)); }

coded::Weights random_weights(Random& random, int bits) {
  coded::Weights weights{};
  std::uint32_t left = std::uint32_t{1} << bits;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint32_t kind = pick(random, 0, 9);  // often 0, sometimes all
    weights[i] = i == 3 || kind == 9 ? left : kind < 2 ? 0 : pick(random, 0, left);
    left -= weights[i];
  }
  return weights;
}

coded::CodedPart random_part(Random& random, const coded::CodedNode& node, std::uint8_t place,
                             std::uint32_t count) {
  coded::CodedPart part;
  part.place = place;
  for (std::uint32_t v = 0; v < count; ++v) {
    part.positions.push_back(random_weights(random, node.position_bits));
    if (node.has_normals) part.normals.push_back({random_byte(random), random_byte(random)});
    if (node.has_colors)
      part.colors.push_back(
          {random_byte(random), random_byte(random), random_byte(random), random_byte(random)});
  }
  std::uint32_t next = 0;
  std::uint32_t extra = count == 0 ? 0 : pick(random, 3, 30);  // triangles after the last new vertex
  while (next < count || extra > 0) {
    extra -= next == count ? 1 : 0;
    Triangle t{};
    for (auto& v : t) {
      v = next < count && pick(random, 0, 1) == 0 ? next : pick(random, 0, next == count ? count - 1 : next);
      next += v == next ? 1 : 0;
    }
    part.triangles.push_back(t);
  }
  // The farthest that an index can be from the newest vertex.
  if (count > 0) part.triangles.push_back({0, count - 1, 0});
  return part;
}

coded::CodedNode node_with(int bits, bool has_normals, bool has_colors) {
  coded::CodedNode node;
  node.position_bits = bits;
  node.has_normals = has_normals;
  node.has_colors = has_colors;
  return node;
}

coded::CodedNode random_node(Random& random, int bits, bool has_normals, bool has_colors,
                             std::uint32_t most_vertices) {
  coded::CodedNode node = node_with(bits, has_normals, has_colors);
  for (std::uint8_t place = 0; place < 8; ++place)
    if (pick(random, 0, 1) == 0)
      node.parts.push_back(random_part(random, node, place, pick(random, 0, most_vertices)));
  return node;
}

coded::CodedNode in_order(coded::CodedNode node, const Codec& codec) {
  for (coded::CodedPart& part : node.parts) put_in_order(part, codec);
  return node;
}

core::Bytes bytes_of(const coded::CodedNode& node, const Codec& codec) { return encode(node, codec).bytes; }

// No test has more.
constexpr NodeCounts kMost{1000000, 1000000};

void expect_round_trip(const coded::CodedNode& node) {
  for (const Codec& codec : codecs()) {
    SCOPED_TRACE(codec.name);
    const coded::CodedNode ordered = in_order(node, codec);
    const auto decoded = decode_with_weights(bytes_of(ordered, codec), kMost);
    ASSERT_TRUE(decoded) << decoded.defect().message << " at " << decoded.defect().offset;
    EXPECT_TRUE(decoded.value() == ordered);
  }
}

TEST(NodeCodec, DecodesWhatItEncoded) {
  std::uint64_t seed = 100;
  for (int bits = coded::kMinPositionBits; bits <= coded::kMaxPositionBits; ++bits)
    for (const bool has_normals : {false, true})
      for (const bool has_colors : {false, true})
        for (int round = 0; round < 8; ++round) {
          Random random(++seed);
          SCOPED_TRACE(testing::Message() << "seed " << seed << ", bits " << bits);
          expect_round_trip(random_node(random, bits, has_normals, has_colors, 200));
        }
}

// Where the width of an index changes.
TEST(NodeCodec, DecodesAnyNumberOfVertices) {
  for (const std::uint32_t count : {0U, 1U, 254U, 255U, 256U, 257U, 65534U, 65535U, 65536U, 65537U, 70000U}) {
    constexpr std::uint64_t kSeed = 1;
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", vertices " << count);
    Random random(kSeed);
    coded::CodedNode node = node_with(12, false, false);
    node.parts.push_back(random_part(random, node, 5, count));
    expect_round_trip(node);
  }
}

TEST(NodeCodec, RefusesAnyOtherLength) {
  for (const Codec& codec : codecs())
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(testing::Message() << codec.name << ", seed " << seed);
      Random random(seed);
      coded::CodedNode node =
          random_node(random, static_cast<int>(8 + seed % 9), seed % 2 == 0, seed % 3 == 0, 20);
      node.parts.resize(std::min<std::size_t>(node.parts.size(), 4));
      core::Bytes bytes = bytes_of(in_order(node, codec), codec);
      for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(decode_with_weights(std::span(bytes).first(size), kMost))
            << "cut to " << size << " of " << bytes.size();
      bytes.push_back(std::byte{0});
      EXPECT_FALSE(decode_with_weights(bytes, kMost));
    }
}

TEST(NodeCodec, RefusesMoreThanTheNodeTableSays) {
  Random random(5);
  coded::CodedNode node = node_with(12, true, true);
  node.parts.push_back(random_part(random, node, 5, 100));
  const NodeCounts counts{100, node.parts[0].triangles.size()};
  for (const Codec& codec : codecs()) {
    const core::Bytes bytes = bytes_of(in_order(node, codec), codec);
    EXPECT_TRUE(decode_with_weights(bytes, counts));
    EXPECT_FALSE(decode_with_weights(bytes, {counts.vertices - 1, counts.triangles}));
    EXPECT_FALSE(decode_with_weights(bytes, {counts.vertices, counts.triangles - 1}));
  }
}

// Puts the right checksum at the end.
void seal(core::Bytes& bytes) {
  const std::size_t size = bytes.size() - sizeof(std::uint64_t);
  const std::uint64_t checksum = core::hash64(std::span(bytes).first(size));
  std::memcpy(bytes.data() + size, &checksum, sizeof checksum);
}

void expect_valid(const coded::CodedNode& node) {
  EXPECT_GE(node.position_bits, coded::kMinPositionBits);
  EXPECT_LE(node.position_bits, coded::kMaxPositionBits);
  int last_place = -1;
  for (const coded::CodedPart& part : node.parts) {
    EXPECT_GT(int{part.place}, last_place);
    EXPECT_LT(int{part.place}, 8);
    last_place = part.place;
    const std::size_t count = part.positions.size();
    for (const coded::Weights& w : part.positions) {
      EXPECT_EQ(std::uint64_t{w[0]} + w[1] + w[2] + w[3], std::uint64_t{1} << node.position_bits);
    }
    EXPECT_EQ(part.normals.size(), node.has_normals ? count : 0);
    EXPECT_EQ(part.colors.size(), node.has_colors ? count : 0);
    for (const Triangle& t : part.triangles)
      for (const std::uint32_t v : t) EXPECT_LT(v, count);
    EXPECT_EQ(coded::used_vertices(part.triangles, count), count);
  }
}

coded::CodedNode three_parts(std::uint64_t seed) {
  Random random(seed);
  coded::CodedNode node = node_with(static_cast<int>(8 + seed % 9), seed % 2 == 0, seed % 3 == 0);
  for (const std::uint8_t place : std::array<std::uint8_t, 3>{0, 3, 7})
    node.parts.push_back(random_part(random, node, place, 6));
  return node;
}

TEST(NodeCodec, RefusesAnyFlippedBit) {
  for (const Codec& codec : codecs())
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const core::Bytes original = bytes_of(in_order(three_parts(seed), codec), codec);
      for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
        core::Bytes bytes = original;
        bytes[bit / 8] ^= std::byte{1} << bit % 8;
        EXPECT_FALSE(decode_with_weights(bytes, kMost)) << codec.name << ", seed " << seed << ", bit " << bit;
      }
    }
}

// What the checksum would catch, with the checksum made right again.
TEST(NodeCodec, AnyFlippedBitUnderARightChecksumIsRefusedOrAValidNode) {
  for (const Codec& codec : codecs()) {
    std::size_t refused = 0;
    std::size_t accepted = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const core::Bytes original = bytes_of(in_order(three_parts(seed), codec), codec);
      for (std::size_t bit = 0; bit < 8 * (original.size() - sizeof(std::uint64_t)); ++bit) {
        SCOPED_TRACE(testing::Message() << codec.name << ", seed " << seed << ", bit " << bit);
        core::Bytes bytes = original;
        bytes[bit / 8] ^= std::byte{1} << bit % 8;
        seal(bytes);
        const auto decoded = decode_with_weights(bytes, {100, 200});
        ++(decoded ? accepted : refused);
        if (!decoded) continue;
        expect_valid(decoded.value());
        if (HasFailure()) return;
      }
    }
    EXPECT_GT(refused, 1000U) << codec.name;
    EXPECT_GT(accepted, 100U) << codec.name;
  }
}

// Whoever expects the other kind of positions, or no parents, is told what there is.
TEST(NodeCodec, RefusesWhatItIsNotAskedFor) {
  coded::CodedNode node = node_with(12, false, false);
  node.parts.resize(1);
  const auto expect_refused = [](const auto& decoded, const char* message) {
    ASSERT_FALSE(decoded);
    EXPECT_EQ(decoded.defect().message, message);
  };
  for (const Codec& codec : codecs()) {
    SCOPED_TRACE(codec.name);
    EXPECT_TRUE(decode_with_weights(bytes_of(node, codec), kMost));
    expect_refused(decode_on_lattice(bytes_of(node, codec), kMost),
                   "expected positions on the lattice, found weights");
    const coded::CodedNode other = coded::lattice_node();
    EXPECT_TRUE(decode_on_lattice(bytes_of(other, codec), kMost));
    expect_refused(decode_with_weights(bytes_of(other, codec), kMost),
                   "expected weights for positions, found some on the lattice");
    coded::CodedNode parented = node;
    parented.has_parents = true;
    expect_refused(decode_with_weights(bytes_of(parented, codec), kMost),
                   "expected weights for positions, found vertices with parents");
  }
}

TEST(NodeCodecDeathTest, RefusesToEncodeWhatItCouldNotDecode) {
  const Codec& codec = codecs().front();
  coded::CodedNode node = node_with(coded::kMaxPositionBits + 1, false, false);
  EXPECT_DEATH(encode(node, codec), "position bits out of range");
  node.position_bits = 12;
  node.parts.resize(1);
  node.parts[0].normals.resize(1);
  EXPECT_DEATH(encode(node, codec), "1 normals");
}

}  // namespace
}  // namespace colossus::codec
