#include "codec/entropy/range_coder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace colossus::codec::entropy {
namespace {

using Random = std::mt19937_64;

constexpr std::size_t kModelCount = 5;
using Models = std::array<BitModel, kModelCount>;

struct Symbol {
  bool bit;
  std::size_t model;
};

// The bits of model i are 1 with probability 2^(-3 i), so some hardly ever.
std::vector<Symbol> random_symbols(Random& random, std::size_t count) {
  std::vector<Symbol> symbols(count);
  for (Symbol& symbol : symbols) {
    symbol.model = random() % kModelCount;
    symbol.bit = random() % (std::uint64_t{1} << 3 * symbol.model) == 0;
  }
  return symbols;
}

core::Bytes encoded(const std::vector<Symbol>& symbols) {
  RangeEncoder encoder;
  Models models;
  for (const Symbol& symbol : symbols) encoder.encode(symbol.bit, models[symbol.model]);
  return encoder.finish();
}

TEST(RangeCoder, DecodesWhatItEncodedAndEndsWithTheBytes) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::vector<Symbol> symbols = random_symbols(random, seed < 100 ? seed - 1 : random() % 5000);
    const core::Bytes bytes = encoded(symbols);
    RangeDecoder decoder(bytes);
    Models models;
    for (std::size_t i = 0; i < symbols.size(); ++i)
      ASSERT_EQ(decoder.decode(models[symbols[i].model]), symbols[i].bit) << "bit " << i;
    EXPECT_EQ(decoder.offset(), bytes.size());
  }
}

// Where one bit alone is against the model, carries run through many bytes of 0xff.
TEST(RangeCoder, CarriesRunThroughAnyNumberOfBytes) {
  for (std::size_t length = 0; length < 4000; length += 7) {
    RangeEncoder encoder;
    BitModel model;
    const auto bit_at = [&](std::size_t i) { return i == length || i % 3 == 1; };
    for (std::size_t i = 0; i <= length; ++i) encoder.encode(bit_at(i), model);
    const core::Bytes bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    BitModel again;
    for (std::size_t i = 0; i <= length; ++i)
      ASSERT_EQ(decoder.decode(again), bit_at(i)) << "bit " << i << " of " << length;
  }
}

TEST(RangeCoder, TakesWhatTheProbabilitiesSay) {
  constexpr std::size_t kCount = 200000;
  for (const double probability : {0.5, 0.2, 0.05, 0.004}) {
    SCOPED_TRACE(testing::Message() << "probability " << probability);
    Random random(1);
    const auto limit = static_cast<std::uint64_t>(probability * 1e9);
    RangeEncoder encoder;
    BitModel model;
    for (std::size_t i = 0; i < kCount; ++i) encoder.encode(random() % 1000000000 < limit, model);
    const double entropy =
        -probability * std::log2(probability) - (1 - probability) * std::log2(1 - probability);
    const double bits = 8.0 * static_cast<double>(encoder.finish().size()) / kCount;
    EXPECT_GT(bits, 0.97 * entropy);
    EXPECT_LT(bits, 1.07 * entropy);
  }
}

TEST(RangeCoder, DecodesAnyBytes) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    core::Bytes bytes(random() % 40);
    for (auto& byte : bytes) byte = static_cast<std::byte>(seed % 3 == 0 ? 0xff : random());
    RangeDecoder decoder(bytes);
    Models models;
    constexpr std::size_t kBits = 2000;
    for (std::size_t i = 0; i < kBits; ++i) decoder.decode(models[random() % kModelCount]);
    EXPECT_LE(decoder.offset(), 4 + 2 * kBits) << "seed " << seed;
  }
}

TEST(BitModel, IsNeverCertain) {
  for (const bool bit : {false, true}) {
    BitModel model;
    for (int i = 0; i < 10000; ++i) {
      model.update(bit);
      ASSERT_GT(model.probability_of_zero(), 0U);
      ASSERT_LT(model.probability_of_zero(), std::uint32_t{1} << BitModel::kProbabilityBits);
    }
  }
}

}  // namespace
}  // namespace colossus::codec::entropy
