// A pseudo-random permutation of 0 .. count-1 that needs no memory: a Feistel network over the next even
// number of bits, applied again while the result is not below count (cycle walking; fewer than four rounds on
// average).
#pragma once

#include <array>
#include <cstdint>

#include "core/hash.hpp"

namespace colossus::input {

class SynthOrder {
 public:
  SynthOrder(std::uint64_t count, std::uint64_t seed) : count_(count) {
    while (half_bits_ < 32 && (std::uint64_t{1} << (2 * half_bits_)) < count) ++half_bits_;
    mask_ = (std::uint64_t{1} << half_bits_) - 1;
    for (std::uint64_t& key : keys_) key = seed = core::mix64(seed + 0x9e3779b97f4a7c15ULL);
  }

  // Both for index < count, and inverse to each other.
  std::uint64_t forward(std::uint64_t index) const {
    do {
      std::uint64_t left = index >> half_bits_, right = index & mask_;
      for (std::size_t i = 0; i < keys_.size(); ++i) {
        const std::uint64_t next = left ^ scramble(right, keys_[i]);
        left = right;
        right = next;
      }
      index = (left << half_bits_) | right;
    } while (index >= count_);
    return index;
  }
  std::uint64_t backward(std::uint64_t index) const {
    do {
      std::uint64_t left = index >> half_bits_, right = index & mask_;
      for (std::size_t i = keys_.size(); i-- > 0;) {
        const std::uint64_t previous = right ^ scramble(left, keys_[i]);
        right = left;
        left = previous;
      }
      index = (left << half_bits_) | right;
    } while (index >= count_);
    return index;
  }

 private:
  std::uint64_t scramble(std::uint64_t half, std::uint64_t key) const {
    const std::uint64_t x = (half ^ key) * 0x9fb21c651e98df25ULL;
    return (((x ^ (x >> 35)) * 0x9e3779b97f4a7c15ULL) >> 24) & mask_;
  }

  std::uint64_t count_;
  unsigned half_bits_ = 1;
  std::uint64_t mask_ = 0;
  std::array<std::uint64_t, 4> keys_{};
};

}  // namespace colossus::input
