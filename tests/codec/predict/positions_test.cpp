// The decoder takes short cuts through doubles, the encoder takes none: whatever goes in comes out, also
// where coordinates are as great as only bytes of no sense make them.
#include "codec/predict/positions.hpp"

#include <gtest/gtest.h>

#include <random>

#include "codec/coded/renumber.hpp"
#include "codec/predict/connectivity.hpp"

namespace colossus::codec::predict {
namespace {

using Random = std::mt19937_64;

std::uint32_t pick(Random& random, std::uint32_t low, std::uint32_t high) {
  return std::uniform_int_distribution<std::uint32_t>(low, high)(random);
}

struct Square {
  coded::CodedPart part;              // as the codec wants it, without positions
  std::vector<std::uint32_t> places;  // of the vertices, row by row
};

// Of 2 * width * width triangles.
Square square(std::uint32_t width) {
  coded::CodedPart part;
  const auto at = [&](std::uint32_t x, std::uint32_t y) { return y * (width + 1) + x; };
  for (std::uint32_t y = 0; y < width; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      part.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      part.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  order_by_traversal(part.triangles, at(width, width) + 1);
  const std::vector<std::uint32_t> places =
      coded::renumber_by_first_use(part.triangles, at(width, width) + 1);
  part.positions.resize(places.size());
  return {part, places};
}

std::vector<coded::Coordinates> decoded(const core::Bytes& bits, const core::Bytes& values,
                                        const Links& links, const coded::CodedNode& node,
                                        const coded::CodedPart& part) {
  coded::CodedPart result = part;
  result.positions.assign(part.positions.size(), {});
  entropy::RangeDecoder face_bits(bits);
  FaceModel faces;
  ValueDecoder decoder(values, kPositionContexts, TableLayout::kRuns);
  decode_positions(face_bits, faces, decoder, basis_of(part.frame), links, node, result);
  EXPECT_TRUE(decoder.is_done());
  return result.positions;
}

void expect_round_trip(const coded::CodedNode& node, const coded::CodedPart& part) {
  LinkStore store(part.positions.size());
  ConnectivityEncoder().encode(part, store);
  const Links links = store.first(part.positions.size());
  entropy::RangeEncoder bits;
  FaceModel faces;
  ValueEncoder values(kPositionContexts);
  encode_positions(bits, faces, values, basis_of(part.frame), links, node, part);
  ASSERT_EQ(decoded(bits.finish_without_zeros(), values.finish(), links, node, part), part.positions);
}

coded::Frame any_frame(Random& random) {
  coded::Frame frame;
  for (auto& row : frame)
    for (auto& entry : row)
      entry = static_cast<std::int8_t>(static_cast<int>(pick(random, 0, 2 * coded::kGreatestFrameEntry)) -
                                       coded::kGreatestFrameEntry);
  return frame;
}

// Numbers of each size up to 32 bits, around 0 or another number, many of them at the ends of what is narrow.
std::uint32_t any_number(Random& random, std::uint32_t center, std::uint32_t bits) {
  if (pick(random, 0, 15) == 0) {
    const std::array<std::uint32_t, 8> extremes{0,           (1U << 18) - 1, 1U << 18,    0U - (1U << 18),
                                                0x7fffffffU, 0x80000000U,    0xffffffffU, ~(1U << 18)};
    if (bits >= 16) return extremes[pick(random, 0, 7)];
  }
  return center + (pick(random, 0, ~0U) >> (32 - bits)) - (1U << (bits - 1));
}

TEST(Positions, OfAnySizeSurvive) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    coded::CodedPart part = square(pick(random, 1, 12)).part;
    coded::CodedNode node;
    node.position_kind = coded::PositionKind::kLattice;
    node.position_bits = static_cast<int>(pick(random, 0, 32));
    const std::uint32_t bits = pick(random, 1, 32);
    const std::uint32_t center = pick(random, 0, 1) == 0 ? 0 : pick(random, 0, 1U << 18);
    // Now and then one that is out of range among many that are not.
    const bool has_odd_ones = pick(random, 0, 2) == 0;
    for (coded::Coordinates& p : part.positions) {
      for (std::size_t i = 0; i < 3; ++i) p[i] = any_number(random, center, bits);
      if (has_odd_ones && pick(random, 0, 99) == 0) p[pick(random, 0, 2)] = pick(random, 0, ~0U);
    }
    ASSERT_NO_FATAL_FAILURE(expect_round_trip(node, part));
  }
}

// Weights within bounds and out of them, on the faces and off, in tetrahedra of any shape.
TEST(Positions, WeightsOfAnyTetrahedronSurvive) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    coded::CodedPart part = square(pick(random, 1, 12)).part;
    part.frame = any_frame(random);
    coded::CodedNode node;
    node.position_bits = static_cast<int>(pick(random, 0, 20));
    const std::uint32_t one = 1U << node.position_bits;
    const bool is_wild = pick(random, 0, 3) == 0;
    for (coded::Coordinates& w : part.positions) {
      std::uint32_t left = one;
      for (std::size_t i = 0; i < 3; ++i) {
        w[i] = is_wild ? any_number(random, one / 4, pick(random, 1, 32)) : pick(random, 0, left);
        if (pick(random, 0, 5) == 0) w[i] = 0;
        left -= w[i];
      }
      w[3] = left;
      std::rotate(w.begin(), w.begin() + pick(random, 0, 3), w.end());
    }
    ASSERT_NO_FATAL_FAILURE(expect_round_trip(node, part));
  }
}

// Planes of each steepness: a height is a quotient that lies near an integer, or halfway between two.
TEST(Positions, OfPlanesSurvive) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::uint32_t width = pick(random, 2, 12);
    auto [part, places] = square(width);
    coded::CodedNode node;
    node.position_kind = coded::PositionKind::kLattice;
    node.position_bits = 18;
    const std::uint32_t step = pick(random, 1, 4000);
    const std::array<std::uint32_t, 3> slopes{pick(random, 0, 8), pick(random, 0, 8), pick(random, 1, 8)};
    const std::size_t axis = pick(random, 0, 2);
    for (std::uint32_t v = 0; v < part.positions.size(); ++v) {
      const std::uint32_t x = places[v] % (width + 1) * step + pick(random, 0, 1);
      const std::uint32_t y = places[v] / (width + 1) * step + pick(random, 0, 1);
      part.positions[v][axis] = (slopes[0] * x + slopes[1] * y) / slopes[2] + pick(random, 0, 1);
      part.positions[v][(axis + 1) % 3] = x;
      part.positions[v][(axis + 2) % 3] = y;
    }
    ASSERT_NO_FATAL_FAILURE(expect_round_trip(node, part));
  }
}

}  // namespace
}  // namespace colossus::codec::predict
