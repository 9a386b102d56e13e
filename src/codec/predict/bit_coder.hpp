// Adaptive binary range coder (G. N. N. Martin, 1979), with carries resolved as in LZMA's: for the few
// symbols whose statistics have to be learned on the way.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/bytes.hpp"

namespace colossus::codec::predict {

// The probability that the next bit is 0, in units of 2^-16: the mean of what was seen, over a window that
// grows to some fifty bits.
class BitModel {
 public:
  std::uint32_t zero() const { return zero_; }
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

inline constexpr std::uint32_t kLeastRange = 1 << 24;

class BitEncoder {
 public:
  void put(BitModel& model, bool bit) {
    const std::uint32_t bound = (range_ >> 16) * model.zero();
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
  void put_bits(std::uint32_t value, int count) {
    for (int i = count; i-- > 0;) {
      range_ >>= 1;
      if ((value >> i & 1U) != 0) low_ += range_;
      normalize();
    }
  }
  // Ends the stream. Zeros at the end are left out: the decoder supplies them.
  core::Bytes finish() {
    for (int i = 0; i < 5; ++i) shift();
    // The first byte is always 0.
    bytes_.erase(bytes_.begin());
    while (!bytes_.empty() && bytes_.back() == std::byte{0}) bytes_.pop_back();
    return std::move(bytes_);
  }

 private:
  void normalize() {
    while (range_ < kLeastRange) {
      range_ <<= 8;
      shift();
    }
  }
  void shift() {
    if (low_ < 0xff000000U || low_ > 0xffffffffU) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      for (; pending_ > 0; --pending_) {
        bytes_.push_back(static_cast<std::byte>(cache_ + carry));
        cache_ = 0xff;
      }
      cache_ = static_cast<std::uint8_t>(low_ >> 24);
    }
    ++pending_;
    low_ = (low_ & 0x00ffffffU) << 8;
  }

  core::Bytes bytes_;
  std::uint64_t low_ = 0;
  std::uint64_t pending_ = 1;
  std::uint32_t range_ = 0xffffffff;
  std::uint8_t cache_ = 0;
};

// Total on any bytes: those that are missing read as 0.
class BitDecoder {
 public:
  explicit BitDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
  }
  bool get(BitModel& model) {
    const std::uint32_t bound = (range_ >> 16) * model.zero();
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
  std::uint32_t get_bits(int count) {
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

 private:
  std::uint32_t next() {
    return offset_ < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[offset_++]) : 0;
  }
  void normalize() {
    while (range_ < kLeastRange) {
      range_ <<= 8;
      code_ = code_ << 8 | next();
    }
  }

  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint32_t code_ = 0;
};

// A number of kBits bits, the highest first, each in the context of those before it.
template <int kBits>
class TreeModel {
 public:
  void put(BitEncoder& encoder, std::uint32_t value) {
    std::uint32_t at = 1;
    for (int i = kBits; i-- > 0;) {
      const bool bit = (value >> i & 1U) != 0;
      encoder.put(models_[at], bit);
      at = at << 1 | (bit ? 1U : 0U);
    }
  }
  std::uint32_t get(BitDecoder& decoder) {
    std::uint32_t at = 1;
    for (int i = 0; i < kBits; ++i) at = at << 1 | (decoder.get(models_[at]) ? 1U : 0U);
    return at - (1U << kBits);
  }

 private:
  std::array<BitModel, std::size_t{1} << kBits> models_;
};

}  // namespace colossus::codec::predict
