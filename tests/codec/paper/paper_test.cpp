#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <random>
#include <string_view>

#include "codec/paper/coefficient_model.hpp"
#include "codec/paper/haar.hpp"
#include "codec/paper/paper_codec.hpp"
#include "codec/paper/strips.hpp"

namespace colossus::codec::paper {
namespace {

using mesh::Triangle;
using Random = std::mt19937_64;

// Both ends included.
template <typename T>
T pick(Random& random, T low, T high) {
  return std::uniform_int_distribution<T>(low, high)(random);
}

std::int64_t pick_signed(Random& random, int bits) {
  const std::int64_t half = std::int64_t{1} << (bits - 1);
  switch (pick(random, 0, 5)) {
    case 0:
      return -half;
    case 1:
      return half - 1;
    case 2:
      return pick<std::int64_t>(random, -1, 0);
    default:
      return pick(random, -half, half - 1);
  }
}

bool has_bits(std::int64_t value, int bits) {
  const std::int64_t half = std::int64_t{1} << (bits - 1);
  return value >= -half && value < half;
}

void expect_reversible(const ValuePair& values, int bits) {
  const HaarPair pair = haar_forward(values);
  ASSERT_TRUE(has_bits(pair.low, bits) && has_bits(pair.high, bits)) << values.first << ' ' << values.second;
  ASSERT_EQ(haar_inverse(pair), values) << values.first << ' ' << values.second;
}

TEST(Haar, MapsAllPairsOfNBitsToAllPairsOfNBits) {
  for (int bits = 1; bits <= 8; ++bits) {
    const std::int64_t half = std::int64_t{1} << (bits - 1);
    for (std::int64_t first = -half; first < half; ++first)
      for (std::int64_t second = -half; second < half; ++second) {
        expect_reversible({first, second}, bits);
        const ValuePair back = haar_inverse({first, second});
        ASSERT_TRUE(has_bits(back.first, bits) && has_bits(back.second, bits));
        ASSERT_EQ(haar_forward(back), (HaarPair{first, second}));
        if (HasFatalFailure()) return;
      }
  }
}

TEST(Haar, IsReversibleForWiderNumbers) {
  for (int bits = 9; bits <= kMaxTransformBits; ++bits) {
    SCOPED_TRACE(testing::Message() << "seed and bits " << bits);
    Random random(static_cast<std::uint64_t>(bits));
    for (int i = 0; i < 20000; ++i) {
      expect_reversible({pick_signed(random, bits), pick_signed(random, bits)}, bits);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Haar, HasNoDifferenceForEqualValuesAndASmallOneForNeighbours) {
  for (std::int64_t value = -128; value < 127; ++value) {
    EXPECT_EQ(haar_forward({value, value}).high, 0) << value;
    EXPECT_EQ(haar_forward({value, value}).low, value);
    EXPECT_LE(std::abs(haar_forward({value, value + 1}).high), 1) << value;
    EXPECT_LE(std::abs(haar_forward({value + 1, value}).high), 1) << value;
  }
}

TEST(Haar, UndoesStreamsOfAnyLength) {
  for (std::size_t count = 0; count < 140; ++count) {
    SCOPED_TRACE(testing::Message() << "seed and length " << count);
    Random random(count);
    const int bits = pick(random, 1, kMaxTransformBits);
    std::vector<std::int64_t> values(count);
    for (auto& value : values) value = pick_signed(random, bits);
    std::vector<std::int64_t> transformed = values;
    haar_analyze(transformed);
    std::vector<std::int64_t> differences;
    for (std::size_t step = last_haar_step(count); step > 0; step /= 2)
      for (std::size_t i = step; i < count; i += 2 * step) differences.push_back(transformed[i]);
    ASSERT_EQ(differences.size(), count == 0 ? 0 : count - 1);
    std::vector<std::int64_t> back(count);
    if (count > 0) back[0] = transformed[0];
    auto next = differences.begin();
    haar_synthesize(back, [&] { return *next++; });
    EXPECT_EQ(back, values);
  }
}

TEST(CoefficientModel, DecodesNumbersOfAnyWidth) {
  for (int bits = 1; bits <= CoefficientModel::kMaxBits; ++bits) {
    SCOPED_TRACE(testing::Message() << "seed and bits " << bits);
    Random random(static_cast<std::uint64_t>(bits));
    std::vector<std::int64_t> values(300);
    for (auto& value : values) value = pick_signed(random, bits) >> pick(random, 0, bits - 1);
    entropy::RangeEncoder encoder;
    CoefficientModel model;
    for (const std::int64_t value : values) model.encode(encoder, value, bits);
    const core::Bytes bytes = encoder.finish();
    entropy::RangeDecoder decoder(bytes);
    CoefficientModel again;
    for (const std::int64_t value : values) ASSERT_EQ(again.decode(decoder, bits), value);
    EXPECT_EQ(decoder.offset(), bytes.size());
  }
}

TEST(CoefficientModel, DecodesAnyBytesToNumbersOfTheirWidth) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    core::Bytes bytes(pick<std::size_t>(random, 0, 2000));
    for (auto& byte : bytes) byte = static_cast<std::byte>(random());
    const int bits = pick(random, 1, CoefficientModel::kMaxBits);
    entropy::RangeDecoder decoder(bytes);
    CoefficientModel model;
    for (int i = 0; i < 500; ++i) ASSERT_TRUE(has_bits(model.decode(decoder, bits), bits)) << "seed " << seed;
  }
}

// Triangles as a multiset, whatever corner each begins with.
std::map<Triangle, int> counted(const std::vector<Triangle>& triangles) {
  std::map<Triangle, int> counts;
  for (Triangle t : triangles) {
    while (t[0] > t[1] || t[0] > t[2]) std::rotate(t.begin(), t.begin() + 1, t.end());
    if (t[0] == t[2]) t = {t[0], t[0], t[1]};
    ++counts[t];
  }
  return counts;
}

std::vector<Triangle> grid(std::uint32_t side) {
  std::vector<Triangle> triangles;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t v = y * (side + 1) + x;
      triangles.push_back({v, v + 1, v + side + 2});
      triangles.push_back({v, v + side + 2, v + side + 1});
    }
  return triangles;
}

// Any corners at all: edges of many triangles, in both directions, duplicates, vertices named twice or
// thrice.
std::vector<Triangle> soup(Random& random, std::uint32_t vertex_count, std::size_t count) {
  std::vector<Triangle> triangles(count);
  for (Triangle& t : triangles)
    for (auto& v : t) v = pick<std::uint32_t>(random, 0, vertex_count - 1);
  return triangles;
}

void expect_strip_round_trip(const std::vector<Triangle>& triangles) {
  const Strip strip = strip_of(triangles);
  ASSERT_LE(strip.triangle_count, triangles.size());
  EXPECT_LE(strip.indices.size(), kMaxStripIndices * strip.triangle_count);
  std::vector<Triangle> decoded(strip.triangle_count);
  ASSERT_EQ(triangles_of_strip(strip.indices, decoded), decoded.size());
  EXPECT_TRUE(std::equal(decoded.begin(), decoded.end(), triangles.begin()));
  if (strip.triangle_count == triangles.size()) return;
  const Triangle& t = triangles[strip.triangle_count];
  EXPECT_TRUE(t[0] == t[1] || t[1] == t[2] || t[2] == t[0]);
}

TEST(Strips, HoldAnyTriangles) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    expect_strip_round_trip(
        soup(random, pick<std::uint32_t>(random, 1, 40), pick<std::size_t>(random, 0, 200)));
  }
}

TEST(Strips, OrderKeepsTrianglesAndTheSenseOfTheirCorners) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto vertex_count = pick<std::uint32_t>(random, 3, 40);
    std::vector<Triangle> triangles = soup(random, vertex_count, pick<std::size_t>(random, 0, 200));
    const std::map<Triangle, int> before = counted(triangles);
    order_in_strips(triangles, vertex_count);
    EXPECT_EQ(counted(triangles), before);
    expect_strip_round_trip(triangles);
    std::vector<Triangle> again = triangles;
    order_in_strips(again, vertex_count);
    expect_strip_round_trip(again);
  }
}

struct StripCosts {
  double indices_per_triangle = 0.0;
  double misses_per_triangle = 0.0;  // of a cache of 16 vertices, first in, first out
};

StripCosts costs_of(std::vector<Triangle> triangles, std::uint32_t vertex_count) {
  order_in_strips(triangles, vertex_count);
  const Strip strip = strip_of(triangles);
  std::vector<std::uint32_t> cache(16, vertex_count);
  std::size_t misses = 0;
  for (const std::uint32_t v : strip.indices)
    if (std::find(cache.begin(), cache.end(), v) == cache.end()) cache[misses++ % cache.size()] = v;
  const auto count = static_cast<double>(triangles.size());
  return {static_cast<double>(strip.indices.size()) / count, static_cast<double>(misses) / count};
}

TEST(Strips, AreLongAndKindToTheCacheOnAGrid) {
  constexpr std::uint32_t kSide = 60;
  std::vector<Triangle> triangles = grid(kSide);
  Random random(1);
  std::shuffle(triangles.begin(), triangles.end(), random);
  const StripCosts costs = costs_of(triangles, (kSide + 1) * (kSide + 1));
  EXPECT_LT(costs.indices_per_triangle, 1.45);
  EXPECT_LT(costs.misses_per_triangle, 0.75);
}

// No neighbour is looked for twice.
TEST(Strips, TakeNoLongForFansAndHeaps) {
  constexpr std::uint32_t kCount = 200000;
  std::vector<Triangle> fan;
  for (std::uint32_t i = 1; i < kCount; ++i) fan.push_back({0, i, i + 1});
  const std::map<Triangle, int> before = counted(fan);
  order_in_strips(fan, kCount + 1);
  EXPECT_EQ(counted(fan), before);
  expect_strip_round_trip(fan);
  std::vector<Triangle> heap;
  for (std::uint32_t i = 0; i < kCount; ++i)
    heap.push_back(i % 2 == 0 ? Triangle{0, 1, 2 + i} : Triangle{1, 0, 2});
  order_in_strips(heap, kCount + 2);
  expect_strip_round_trip(heap);
}

coded::CodedNode random_node(Random& random, std::uint32_t most_vertices) {
  coded::CodedNode node;
  if (pick(random, 0, 1) == 0) node.position_kind = coded::PositionKind::kLattice;
  node.position_bits = node.is_on_lattice() ? pick(random, 0, 32) : pick(random, 8, 16);
  node.has_normals = pick(random, 0, 1) == 0;
  node.has_colors = pick(random, 0, 1) == 0;
  node.has_parents = pick(random, 0, 1) == 0;
  const std::uint32_t part_count = node.is_on_lattice() ? 1 : pick<std::uint32_t>(random, 0, 8);
  for (std::uint32_t place = 0; place < part_count; ++place) {
    coded::CodedPart part;
    part.place = static_cast<std::uint8_t>(place);
    const auto n = pick<std::uint32_t>(random, 0, most_vertices);
    for (std::uint32_t v = 0; v < n; ++v) {
      std::uint64_t left = std::uint64_t{1} << node.position_bits;
      coded::Coordinates p{};
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = static_cast<std::uint32_t>(
            pick<std::uint64_t>(random, 0, node.is_on_lattice() ? left - 1 : left));
        if (!node.is_on_lattice()) left -= p[i];
      }
      if (!node.is_on_lattice()) p[3] = static_cast<std::uint32_t>(left);
      part.positions.push_back(p);
      const auto byte = [&] { return static_cast<std::uint8_t>(random()); };
      if (node.has_normals) part.normals.push_back({byte(), byte()});
      if (node.has_colors) part.colors.push_back({byte(), byte(), byte(), byte()});
      if (node.has_parents)
        part.parents.push_back(static_cast<std::uint32_t>(random()) >> pick(random, 0, 31));
    }
    if (n > 0) part.triangles = soup(random, n, pick<std::size_t>(random, 0, 2 * n));
    if (pick(random, 0, 1) == 0) order_in_strips(part.triangles, n);
    node.parts.push_back(std::move(part));
  }
  return node;
}

// What decode() finds: the counts and flags, and arrays of zeros.
coded::CodedNode blank(coded::CodedNode node) {
  for (coded::CodedPart& part : node.parts) {
    std::fill(part.positions.begin(), part.positions.end(), coded::Coordinates{});
    std::fill(part.normals.begin(), part.normals.end(), coded::OctahedralNormal{});
    std::fill(part.colors.begin(), part.colors.end(), mesh::Color{});
    std::fill(part.parents.begin(), part.parents.end(), 0);
    std::fill(part.triangles.begin(), part.triangles.end(), Triangle{});
  }
  return node;
}

coded::SectionViews views(const coded::Sections& sections) {
  coded::SectionViews result;
  std::copy(sections.begin(), sections.end(), result.begin());
  return result;
}

bool are_equal(const coded::CodedNode& a, const coded::CodedNode& b) {
  return std::equal(a.parts.begin(), a.parts.end(), b.parts.begin(), b.parts.end(),
                    [](const coded::CodedPart& l, const coded::CodedPart& r) {
                      return l.positions == r.positions && l.normals == r.normals && l.colors == r.colors &&
                             l.parents == r.parents && l.triangles == r.triangles;
                    });
}

void expect_in_range(const coded::CodedNode& node) {
  for (const coded::CodedPart& part : node.parts) {
    for (const Triangle& t : part.triangles)
      for (const std::uint32_t v : t) ASSERT_LT(v, part.positions.size());
    if (!node.is_on_lattice()) continue;
    for (const coded::Coordinates& p : part.positions)
      for (const std::uint32_t coordinate : p)
        ASSERT_LE(coordinate, (std::uint64_t{1} << std::max(1, node.position_bits)) - 1);
  }
}

TEST(PaperCodec, DecodesWhatItEncodedInAnyOrder) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const coded::CodedNode node = random_node(random, seed % 10 == 0 ? 600 : 40);
    const coded::Sections sections = encode_paper(node);
    EXPECT_EQ(sections, encode_paper(node));
    coded::CodedNode decoded = blank(node);
    const auto defect = decode_paper(views(sections), decoded);
    ASSERT_FALSE(defect) << defect->message << " at " << defect->offset;
    EXPECT_TRUE(are_equal(decoded, node));
  }
}

TEST(PaperCodec, TruncatedSectionsAreRefused) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const coded::CodedNode node = random_node(random, 8);
    const coded::Sections sections = encode_paper(node);
    for (std::size_t component = 0; component < coded::kComponentCount; ++component)
      for (std::size_t size = 0; size < sections[component].size(); ++size) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", section " << component << ", size " << size);
        coded::SectionViews cut = views(sections);
        cut[component] = cut[component].first(size);
        coded::CodedNode decoded = blank(node);
        EXPECT_TRUE(decode_paper(cut, decoded));
      }
  }
}

TEST(PaperCodec, FlippedBitsGiveADefectOrIndicesInRange) {
  std::size_t refused = 0;
  std::size_t accepted = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const coded::CodedNode node = random_node(random, 8);
    const coded::Sections sections = encode_paper(node);
    for (std::size_t component = 0; component < coded::kComponentCount; ++component)
      for (std::size_t bit = 0; bit < 8 * sections[component].size(); ++bit) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", section " << component << ", bit " << bit);
        coded::Sections flipped = sections;
        flipped[component][bit / 8] ^= std::byte{1} << bit % 8;
        coded::CodedNode decoded = blank(node);
        const bool is_refused = decode_paper(views(flipped), decoded).has_value();
        ++(is_refused ? refused : accepted);
        if (!is_refused) expect_in_range(decoded);
        if (HasFatalFailure()) return;
      }
  }
  EXPECT_GT(refused, 1000U);
  EXPECT_GT(accepted, 1000U);
}

TEST(PaperCodec, RefusesSectionsThatShouldBeEmpty) {
  coded::CodedNode node;
  node.position_bits = 8;
  const core::Bytes bytes(1);
  for (std::size_t component = 0; component < coded::kComponentCount; ++component) {
    coded::SectionViews sections;
    sections[component] = bytes;
    EXPECT_TRUE(decode_paper(sections, node)) << component;
  }
  EXPECT_FALSE(decode_paper({}, node));
}

coded::CodedNode golden_node() {
  coded::CodedNode node;
  node.position_bits = 12;
  node.has_normals = node.has_colors = node.has_parents = true;
  coded::CodedPart part;
  part.place = 2;
  part.positions = {{4096, 0, 0, 0}, {1000, 2000, 500, 596}, {0, 1, 4094, 1}, {1365, 1365, 1366, 0}};
  part.normals = {{1, 2}, {128, 255}, {0, 7}, {64, 64}};
  part.colors = {{1, 2, 3, 4}, {255, 254, 253, 252}, {10, 20, 30, 40}, {0, 0, 0, 255}};
  part.parents = {0, 7, 8, 300};
  part.triangles = {{0, 1, 2}, {2, 1, 3}, {0, 3, 1}, {3, 3, 0}};
  node.parts = {part, part};
  return node;
}

// The sections of golden_node(), in hexadecimal digits.
constexpr std::array<std::string_view, coded::kComponentCount> kGolden{
    "f141cd18d477a149a49209ad4e55",
    "fff7fe6013c61fde110f8128707abffc0966032e660a3d9905f860e669dab2f2e7cba6c61b702b47f5aba29b56"
    "eca9e39bc6c1f1339efbae169f8a4707edd34000",
    "ff01a3a5ebb0d865dfec73927e42044afa1244e7d1a6f49aa973282f60",
    "feffdd83f574734d30690f94fa2a2a7445fdc40d0bd1ad9e63bda86a4664d336c690ce90605ba0",
    "f17fa03f968e37aaa5e7b89be2ec0974db2760"};

core::Bytes bytes_of(std::string_view digits) {
  core::Bytes bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    unsigned value = 0;
    std::from_chars(digits.data() + i, digits.data() + i + 2, value, 16);
    bytes.push_back(static_cast<std::byte>(value));
  }
  return bytes;
}

// A change of the encoder's bytes is a new version of the codec, in schemas/ too; what is decoded never
// changes.
TEST(PaperCodec, BytesOfVersion1StayAsTheyAre) {
  coded::Sections golden;
  std::transform(kGolden.begin(), kGolden.end(), golden.begin(), bytes_of);
  EXPECT_EQ(encode_paper(golden_node()), golden);
  coded::CodedNode decoded = blank(golden_node());
  const auto defect = decode_paper(views(golden), decoded);
  ASSERT_FALSE(defect) << defect->message;
  EXPECT_TRUE(are_equal(decoded, golden_node()));
}

}  // namespace
}  // namespace colossus::codec::paper
