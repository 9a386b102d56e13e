// Integers as bits for the range coder: one for the value 0; else exponent, mantissa and sign, each bit with
// a model of its own. After the symbols of FFV1.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "codec/entropy/bit_models.hpp"

namespace colossus::codec::paper {

// Of one stream. Its numbers are signed ones of `bits` bits, 1 to kMaxBits.
class CoefficientModel {
 public:
  static constexpr int kMaxBits = 33;

  void encode(entropy::RangeEncoder& encoder, std::int64_t value, int bits) {
    encoder.encode(value != 0, nonzero_);
    if (value == 0) return;
    const auto magnitude = static_cast<std::uint64_t>(value < 0 ? -value : value);
    const auto exponent = static_cast<std::size_t>(std::bit_width(magnitude) - 1);
    for (std::size_t i = 0; i < exponent; ++i) encoder.encode(true, greater_[i]);
    if (exponent < last_exponent(bits)) encoder.encode(false, greater_[exponent]);
    for (std::size_t i = exponent; i-- > 0;)
      encoder.encode((magnitude >> i & 1) != 0, mantissa_[place(exponent, i)]);
    encoder.encode(value < 0, negative_[exponent]);
  }

  // A number of so many bits, whatever the bytes.
  std::int64_t decode(entropy::RangeDecoder& decoder, int bits) {
    if (!decoder.decode(nonzero_)) return 0;
    std::size_t exponent = 0;
    while (exponent < last_exponent(bits) && decoder.decode(greater_[exponent])) ++exponent;
    std::int64_t magnitude = 1;
    for (std::size_t i = exponent; i-- > 0;)
      magnitude = magnitude * 2 + (decoder.decode(mantissa_[place(exponent, i)]) ? 1 : 0);
    const std::int64_t value = decoder.decode(negative_[exponent]) ? -magnitude : magnitude;
    const std::int64_t half = std::int64_t{1} << (bits - 1);
    return value >= half || value < -half ? -half : value;
  }

 private:
  static std::size_t last_exponent(int bits) { return static_cast<std::size_t>(bits - 1); }

  // A number with this exponent has this many bits below its first.
  static std::size_t place(std::size_t exponent, std::size_t bit) {
    return exponent * (exponent - 1) / 2 + bit;
  }

  entropy::TwoSpeedModel nonzero_;
  std::array<entropy::TwoSpeedModel, kMaxBits> greater_;  // than the exponent i, by i
  std::array<entropy::TwoSpeedModel, kMaxBits> negative_;
  std::array<entropy::TwoSpeedModel, kMaxBits*(kMaxBits - 1) / 2> mantissa_;
};

}  // namespace colossus::codec::paper
