// Sorts integers by some of their bits, in linear time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace colossus::pipeline::ingest {

// Stable, by the bits from `first_bit` up to, without, `end_bit`. Needs as much memory again as the keys.
inline void radix_sort(std::vector<std::uint64_t>& keys, int first_bit, int end_bit) {
  constexpr int kDigitBits = 11;
  constexpr std::uint64_t kDigits = std::uint64_t{1} << kDigitBits;
  std::vector<std::uint64_t> sorted(keys.size());
  for (int bit = first_bit; bit < end_bit; bit += kDigitBits) {
    const std::uint64_t mask = (std::uint64_t{1} << std::min(kDigitBits, end_bit - bit)) - 1;
    std::array<std::size_t, kDigits> starts{};
    for (const std::uint64_t key : keys) ++starts[key >> bit & mask];
    std::size_t next = 0;
    for (std::size_t& start : starts) next += std::exchange(start, next);
    for (const std::uint64_t key : keys) sorted[starts[key >> bit & mask]++] = key;
    keys.swap(sorted);
  }
}

}  // namespace colossus::pipeline::ingest
