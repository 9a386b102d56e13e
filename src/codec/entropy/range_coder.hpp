// A binary adaptive range coder: bits in, bytes out, at nearly the cost that the models' probabilities say.
// Integers only, so that bytes are the same everywhere. After Martin, "Range encoding" (1979), with binary
// decisions and carries kept back as in LZMA's coder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "core/bytes.hpp"

namespace colossus::codec::entropy {

// How probable a 0 is, learnt from the bits so far: the mean of a fast and a slow average.
class BitModel {
 public:
  static constexpr int kProbabilityBits = 14;

  // In units of 2^-kProbabilityBits; never 0 and never 1.
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

// Whoever decodes must ask with the same models in the same order.
class RangeEncoder {
 public:
  void encode(bool bit, BitModel& model) {
    const std::uint32_t bound = (range_ >> BitModel::kProbabilityBits) * model.probability_of_zero();
    if (bit) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.update(bit);
    for (; range_ < kLeastRange; range_ <<= 8) shift_low();
  }

  // Ends the stream. Four bytes, and those of the bits.
  core::Bytes finish() {
    for (std::size_t i = 0; i < kStartBytes + 1; ++i) shift_low();
    bytes_.erase(bytes_.begin());  // a 0 from before the first bit
    return std::move(bytes_);
  }

  static constexpr std::uint32_t kLeastRange = std::uint32_t{1} << 24;
  static constexpr std::size_t kStartBytes = 4;

 private:
  // The top byte of `low_` is known but for a carry, which may run through all 0xff bytes before it.
  void shift_low() {
    if (low_ < 0xff000000 || low_ > 0xffffffff) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      for (; pending_ > 0; --pending_) {
        bytes_.push_back(static_cast<std::byte>(static_cast<std::uint8_t>(cache_ + carry)));
        cache_ = 0xff;
      }
      cache_ = static_cast<std::uint8_t>(low_ >> 24);
    }
    ++pending_;
    low_ = (low_ & 0x00ffffff) << 8;
  }

  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint8_t cache_ = 0;
  std::uint64_t pending_ = 1;  // bytes kept back: the cache, then some 0xff
  core::Bytes bytes_;
};

// Total on any bytes: where they end it goes on with zeros. Each bit takes constant time.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (std::size_t i = 0; i < RangeEncoder::kStartBytes; ++i) code_ = code_ << 8 | next_byte();
  }

  bool decode(BitModel& model) {
    const std::uint32_t bound = (range_ >> BitModel::kProbabilityBits) * model.probability_of_zero();
    const bool bit = code_ >= bound;
    if (bit) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.update(bit);
    for (; range_ < RangeEncoder::kLeastRange; range_ <<= 8) code_ = code_ << 8 | next_byte();
    return bit;
  }

  // Of the bytes read so far; past the end when they did not suffice. After the last bit of what an encoder
  // wrote it is exactly the end.
  std::uint64_t offset() const { return offset_; }

 private:
  std::uint32_t next_byte() {
    const std::uint64_t at = offset_++;
    return at < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at]) : 0;
  }

  std::span<const std::byte> bytes_;
  std::uint64_t offset_ = 0;
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xffffffff;
};

}  // namespace colossus::codec::entropy
