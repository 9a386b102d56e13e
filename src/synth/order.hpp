// A pseudo-random permutation of 0 .. count-1 for writing elements in an order without locality, in hardly
// any memory.
//
// A Feistel network on the place of an index in a grid of about as many rows as columns: six rounds turn the
// row by a random number of the column's, then the column by one of the row's, three times over. (After four,
// indices a row apart are still not quite independent.) The columns are a power of two, so that the grid has
// less than a row more places than `count`; what falls there is sent through again (cycle walking), but
// hardly anything does. An index takes a few nanoseconds.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/hash.hpp"

namespace colossus::synth {

// What goes to a place in a block of the file: the element of that number.
class SynthSlot {
 public:
  static constexpr unsigned kPlaceBits = 16;

  SynthSlot() = default;
  // number < 2^48, place < 2^16.
  SynthSlot(std::uint64_t number, std::uint64_t place) : bits_(number << kPlaceBits | place) {}
  std::uint64_t number() const { return bits_ >> kPlaceBits; }
  std::size_t place() const { return bits_ & ((1U << kPlaceBits) - 1); }

 private:
  std::uint64_t bits_;
};

class SynthOrder {
 public:
  // count >= 1. Memory: about 12 bytes times the square root of the count, 0.8 megabytes for 2^32.
  SynthOrder(std::uint64_t count, std::uint64_t seed)
      : count_(count),
        column_bits_(static_cast<unsigned>(std::bit_width(count - 1)) / 2),
        mask_((std::uint64_t{1} << column_bits_) - 1),
        rows_((count + mask_) >> column_bits_) {
    for (std::size_t i = 0; i < turns_.size(); ++i) {
      seed = core::mix64(seed + 0x9e3779b97f4a7c15ULL);
      const bool of_rows = i % 2 == 0;
      const std::uint64_t bound = std::min(of_rows ? rows_ : mask_ + 1, kMaxTurns);
      turns_[i].resize(of_rows ? mask_ + 1 : rows_);
      for (std::size_t other = 0; other < turns_[i].size(); ++other)
        turns_[i][other] = static_cast<std::uint16_t>((core::mix64(seed + other) >> 32) * bound >> 32);
    }
  }

  // Both for index < count, and inverse to each other.
  std::uint64_t forward(std::uint64_t index) const {
    do {
      std::uint64_t row = index >> column_bits_, column = index & mask_;
      for (std::size_t i = 0; i < turns_.size(); i += 2) {
        row = wrap(row + turns_[i][column] - rows_);
        column = (column + turns_[i + 1][row]) & mask_;
      }
      index = row << column_bits_ | column;
    } while (index >= count_);
    return index;
  }
  std::uint64_t backward(std::uint64_t index) const {
    do {
      std::uint64_t row = index >> column_bits_, column = index & mask_;
      for (std::size_t i = turns_.size(); i > 0; i -= 2) {
        column = (column - turns_[i - 1][row]) & mask_;
        row = wrap(row - turns_[i - 2][column]);
      }
      index = row << column_bits_ | column;
    } while (index >= count_);
    return index;
  }

  // `size` <= 2^16 successive places of the file from `first` on, by ascending number of what goes there: so
  // neighbours, as far as a block has any, are computed one after the other.
  std::vector<SynthSlot> block(std::uint64_t first, std::size_t size) const;

 private:
  // So that 16 bits hold a turn. Beyond a count of 2^32, rows turn not quite as far as they could.
  static constexpr std::uint64_t kMaxTurns = 1U << 16;

  // Adds the rows to what has become negative. A condition would be compiled to a jump that no processor
  // foresees: half of the time of all.
  std::uint64_t wrap(std::uint64_t row) const { return row + (rows_ & (0 - (row >> 63))); }

  std::uint64_t count_;
  unsigned column_bits_;
  std::uint64_t mask_, rows_;
  std::array<std::vector<std::uint16_t>, 6> turns_;  // per column, per row, and so on
};

// A radix sort by the bytes of the numbers, lowest first.
inline std::vector<SynthSlot> SynthOrder::block(std::uint64_t first, std::size_t size) const {
  std::vector<SynthSlot> slots(size), sorted(size);
  for (std::size_t i = 0; i < size; ++i) slots[i] = {forward(first + i), i};
  for (unsigned shift = 0; (count_ - 1) >> shift != 0; shift += 8) {
    const auto digit = [shift](SynthSlot slot) { return slot.number() >> shift & 255U; };
    std::array<std::size_t, 256> begins{};
    for (const SynthSlot slot : slots) ++begins[digit(slot)];
    std::size_t begin = 0;
    for (std::size_t& at : begins) begin += std::exchange(at, begin);
    for (const SynthSlot slot : slots) sorted[begins[digit(slot)]++] = slot;
    slots.swap(sorted);
  }
  return slots;
}

}  // namespace colossus::synth
