#include "codec/entropy/range_coder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "codec/entropy/bit_models.hpp"

namespace colossus::codec::entropy {
namespace {

using Random = std::mt19937_64;

constexpr std::size_t kModelCount = 5;

// With a model: a bit. Without one, kModelCount: `count` bits, each as likely as not.
struct Symbol {
  std::uint32_t value;
  std::size_t model;
  int count = 1;
};

// The bits of model i are 1 with probability 2^(-3 i), so some hardly ever.
std::vector<Symbol> random_symbols(Random& random, std::size_t count) {
  std::vector<Symbol> symbols(count);
  for (Symbol& symbol : symbols) {
    symbol.model = random() % (kModelCount + 1);
    if (symbol.model == kModelCount) {
      symbol.count = static_cast<int>(random() % 33);
      symbol.value = static_cast<std::uint32_t>((random() & 0xffffffff) >> (32 - symbol.count));
    } else {
      symbol.value = random() % (std::uint64_t{1} << 3 * symbol.model) == 0 ? 1 : 0;
    }
  }
  return symbols;
}

template <typename Model>
class RangeCoder : public testing::Test {
 protected:
  using Models = std::array<Model, kModelCount>;

  static RangeEncoder encoder_after(const std::vector<Symbol>& symbols) {
    RangeEncoder encoder;
    Models models;
    for (const Symbol& symbol : symbols)
      if (symbol.model < kModelCount)
        encoder.encode(symbol.value != 0, models[symbol.model]);
      else
        encoder.encode_bits(symbol.value, symbol.count);
    return encoder;
  }

  static void expect_decoded(RangeDecoder& decoder, const std::vector<Symbol>& symbols) {
    Models models;
    for (std::size_t i = 0; i < symbols.size(); ++i) {
      const Symbol& symbol = symbols[i];
      const std::uint32_t value = symbol.model < kModelCount
                                      ? (decoder.decode(models[symbol.model]) ? 1U : 0U)
                                      : decoder.decode_bits(symbol.count);
      ASSERT_EQ(value, symbol.value) << "symbol " << i;
    }
  }
};
using AllModels = testing::Types<TwoSpeedModel, GrowingWindowModel>;
TYPED_TEST_SUITE(RangeCoder, AllModels);

TYPED_TEST(RangeCoder, DecodesWhatItEncodedAndEndsWithTheBytes) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::vector<Symbol> symbols = random_symbols(random, seed < 100 ? seed - 1 : random() % 5000);
    const core::Bytes bytes = this->encoder_after(symbols).finish();
    RangeDecoder decoder(bytes);
    this->expect_decoded(decoder, symbols);
    EXPECT_EQ(decoder.offset(), bytes.size());
  }
}

TYPED_TEST(RangeCoder, DecodesWithoutTheZerosAtTheEnd) {
  std::size_t shorter = 0;
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::vector<Symbol> symbols = random_symbols(random, seed % 40);
    core::Bytes whole = this->encoder_after(symbols).finish();
    const core::Bytes bytes = this->encoder_after(symbols).finish_without_zeros();
    if (!bytes.empty()) {
      EXPECT_NE(bytes.back(), std::byte{0});
    }
    shorter += bytes.size() < whole.size() ? 1 : 0;
    RangeDecoder decoder(bytes);
    this->expect_decoded(decoder, symbols);
    whole.resize(bytes.size());
    EXPECT_EQ(whole, bytes);
  }
  EXPECT_GT(shorter, 0U);
}

// Where one bit alone is against the model, carries run through many bytes of 0xff.
TYPED_TEST(RangeCoder, CarriesRunThroughAnyNumberOfBytes) {
  for (std::size_t length = 0; length < 4000; length += 7) {
    RangeEncoder encoder;
    TypeParam model;
    const auto bit_at = [&](std::size_t i) { return i == length || i % 3 == 1; };
    for (std::size_t i = 0; i <= length; ++i) encoder.encode(bit_at(i), model);
    const core::Bytes bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    TypeParam again;
    for (std::size_t i = 0; i <= length; ++i)
      ASSERT_EQ(decoder.decode(again), bit_at(i)) << "bit " << i << " of " << length;
  }
}

TYPED_TEST(RangeCoder, TakesWhatTheProbabilitiesSay) {
  constexpr std::size_t kCount = 200000;
  for (const double probability : {0.5, 0.2, 0.05, 0.004}) {
    SCOPED_TRACE(testing::Message() << "probability " << probability);
    Random random(1);
    const auto limit = static_cast<std::uint64_t>(probability * 1e9);
    RangeEncoder encoder;
    TypeParam model;
    for (std::size_t i = 0; i < kCount; ++i) encoder.encode(random() % 1000000000 < limit, model);
    const double entropy =
        -probability * std::log2(probability) - (1 - probability) * std::log2(1 - probability);
    const double bits = 8.0 * static_cast<double>(encoder.finish().size()) / kCount;
    EXPECT_GT(bits, 0.97 * entropy);
    EXPECT_LT(bits, 1.08 * entropy);
  }
}

TYPED_TEST(RangeCoder, DecodesAnyBytes) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    core::Bytes bytes(random() % 40);
    for (auto& byte : bytes) byte = static_cast<std::byte>(seed % 3 == 0 ? 0xff : random());
    RangeDecoder decoder(bytes);
    typename TestFixture::Models models;
    constexpr std::size_t kBits = 2000;
    for (std::size_t i = 0; i < kBits; ++i) decoder.decode(models[random() % kModelCount]);
    EXPECT_LE(decoder.offset(), 4 + 2 * kBits) << "seed " << seed;
  }
}

TYPED_TEST(RangeCoder, HasModelsThatAreNeverCertain) {
  for (const bool bit : {false, true}) {
    TypeParam model;
    for (int i = 0; i < 10000; ++i) {
      model.update(bit);
      ASSERT_GT(model.probability_of_zero(), 0U);
      ASSERT_LT(model.probability_of_zero(), std::uint32_t{1} << TypeParam::kProbabilityBits);
    }
  }
}

}  // namespace
}  // namespace colossus::codec::entropy
