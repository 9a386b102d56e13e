// How probable the next bit is, learnt from those before it: what range_coder.hpp codes bits with. A model
// knows nothing of the coder; two codecs adapt differently.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "codec/entropy/range_coder.hpp"

namespace colossus::codec::entropy {

// The mean of a fast and a slow average, so that it follows what changes on the way.
class TwoSpeedModel {
 public:
  static constexpr int kProbabilityBits = 14;

  std::uint32_t probability_of_zero() const {
    return (std::uint32_t{fast_} + slow_) >> (17 - kProbabilityBits);
  }

  void update(bool bit) {
    const std::uint32_t target = bit ? 0 : kOne;
    fast_ = toward(fast_, target, kFastShift);
    slow_ = toward(slow_, target, kSlowShift);
  }

 private:
  static constexpr std::uint32_t kOne = 0xffff;
  static constexpr int kFastShift = 4;
  static constexpr int kSlowShift = 7;

  // Stops short of the target, since the step is rounded towards 0.
  static std::uint16_t toward(std::uint32_t value, std::uint32_t target, int shift) {
    return static_cast<std::uint16_t>(target > value ? value + ((target - value) >> shift)
                                                     : value - ((value - target) >> shift));
  }

  std::uint16_t fast_ = 0x8000;
  std::uint16_t slow_ = 0x8000;
};

// The mean of what was seen, over a window that grows to some fifty bits: it learns at once, for the few
// symbols of a short stream.
class GrowingWindowModel {
 public:
  static constexpr int kProbabilityBits = 16;

  std::uint32_t probability_of_zero() const { return zero_; }

  void update(bool bit) {
    const std::uint32_t rate = kRates[count_];
    if (bit)
      zero_ = static_cast<std::uint16_t>(zero_ - (zero_ * rate >> 16));
    else
      zero_ = static_cast<std::uint16_t>(zero_ + ((kOne - zero_) * rate >> 16));
    count_ = static_cast<std::uint8_t>(count_ + (count_ + 1U < kRates.size() ? 1 : 0));
  }

 private:
  static constexpr std::uint32_t kOne = 1 << 16;
  // 1 / (n + 2).
  static constexpr std::array<std::uint16_t, 48> kRates = [] {
    std::array<std::uint16_t, 48> rates{};
    for (std::uint32_t n = 0; n < rates.size(); ++n) rates[n] = static_cast<std::uint16_t>(kOne / (n + 2));
    return rates;
  }();

  std::uint16_t zero_ = kOne / 2;
  std::uint8_t count_ = 0;
};

// A number of kBits bits, the highest first, each in the context of those before it.
template <int kBits>
class TreeModel {
 public:
  void encode(RangeEncoder& encoder, std::uint32_t value) {
    std::uint32_t at = 1;
    for (int i = kBits; i-- > 0;) {
      const bool bit = (value >> i & 1U) != 0;
      encoder.encode(bit, models_[at]);
      at = at << 1 | (bit ? 1U : 0U);
    }
  }

  std::uint32_t decode(RangeDecoder& decoder) {
    std::uint32_t at = 1;
    for (int i = 0; i < kBits; ++i) at = at << 1 | (decoder.decode(models_[at]) ? 1U : 0U);
    return at - (1U << kBits);
  }

 private:
  std::array<GrowingWindowModel, std::size_t{1} << kBits> models_;
};

}  // namespace colossus::codec::entropy
