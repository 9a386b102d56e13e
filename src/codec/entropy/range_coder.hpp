// A binary adaptive range coder: bits in, bytes out, at nearly the cost that the models' probabilities say.
// Integers only, so that bytes are the same everywhere. After Martin, "Range encoding" (1979), with binary
// decisions and carries kept back as in LZMA's coder.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "core/bytes.hpp"

namespace colossus::codec::entropy {

// How probable a 0 is, in units of 2^-kProbabilityBits, of which there are at most 16; never 0 and never 1.
// See bit_models.hpp.
template <typename Model>
concept BitModel = requires(Model& model, const Model& known, bool bit) {
  requires Model::kProbabilityBits <= 16;
  { known.probability_of_zero() } -> std::same_as<std::uint32_t>;
  model.update(bit);
};

// What encoder and decoder do alike: the range, and which part of it a 0 takes.
class BitRange {
 public:
  static constexpr std::size_t kStartBytes = 4;

 protected:
  template <BitModel Model>
  std::uint32_t part_of_zero(const Model& model) const {
    return (range_ >> Model::kProbabilityBits) * model.probability_of_zero();
  }

  // Then the next byte is due: what is left could be too coarse for a model.
  bool is_narrow() const { return range_ < std::uint32_t{1} << 24; }

  std::uint32_t range_ = 0xffffffff;
};

// Whoever decodes must ask with the same models in the same order.
class RangeEncoder : private BitRange {
 public:
  using BitRange::kStartBytes;

  template <BitModel Model>
  void encode(bool bit, Model& model) {
    const std::uint32_t bound = part_of_zero(model);
    if (bit) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.update(bit);
    normalize();
  }

  // The lowest bits of a value, each as likely as not; at most 32.
  void encode_bits(std::uint32_t value, int count) {
    for (int i = count; i-- > 0;) {
      range_ >>= 1;
      if ((value >> i & 1U) != 0) low_ += range_;
      normalize();
    }
  }

  // Ends the stream. Four bytes, and those of the bits.
  core::Bytes finish() {
    for (std::size_t i = 0; i < kStartBytes + 1; ++i) shift_low();
    bytes_.erase(bytes_.begin());  // a 0 from before the first bit
    return std::move(bytes_);
  }

  // The same without the zeros at the end: a decoder supplies them, but can no longer tell where the end was.
  core::Bytes finish_without_zeros() {
    core::Bytes bytes = finish();
    while (!bytes.empty() && bytes.back() == std::byte{0}) bytes.pop_back();
    return bytes;
  }

 private:
  void normalize() {
    for (; is_narrow(); range_ <<= 8) shift_low();
  }

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
  std::uint8_t cache_ = 0;
  std::uint64_t pending_ = 1;  // bytes kept back: the cache, then some 0xff
  core::Bytes bytes_;
};

// Total on any bytes: where they end it goes on with zeros. Each bit takes constant time.
class RangeDecoder : private BitRange {
 public:
  explicit RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (std::size_t i = 0; i < kStartBytes; ++i) code_ = code_ << 8 | next_byte();
  }

  template <BitModel Model>
  bool decode(Model& model) {
    const std::uint32_t bound = part_of_zero(model);
    const bool bit = code_ >= bound;
    if (bit) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.update(bit);
    normalize();
    return bit;
  }

  // A number of so many bits that encode_bits() has written.
  std::uint32_t decode_bits(int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i) {
      range_ >>= 1;
      const bool bit = code_ >= range_;
      if (bit) code_ -= range_;
      value = value << 1 | (bit ? 1U : 0U);
      normalize();
    }
    return value;
  }

  // Of the bytes read so far; past the end when they did not suffice. After the last bit of what finish() has
  // returned it is exactly the end.
  std::uint64_t offset() const { return offset_; }

 private:
  void normalize() {
    for (; is_narrow(); range_ <<= 8) code_ = code_ << 8 | next_byte();
  }

  std::uint32_t next_byte() {
    const std::uint64_t at = offset_++;
    return at < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at]) : 0;
  }

  std::span<const std::byte> bytes_;
  std::uint64_t offset_ = 0;
  std::uint32_t code_ = 0;
};

}  // namespace colossus::codec::entropy
