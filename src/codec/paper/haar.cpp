#include "codec/paper/haar.hpp"

#include <bit>

namespace colossus::codec::paper {
namespace {

// The square falls into four quadrants by the signs of both values, where -1 stands next to the axis as 0
// does. Each turns into the quarter around one half axis: that of low above 0, of high above 0, of low below,
// of high below. Shifting negative numbers by one, on the way in and out, makes all four alike.
HaarPair rotate(const ValuePair& values) {
  const std::int64_t s = values.first < 0 ? 1 : 0;
  const std::int64_t t = values.second < 0 ? 1 : 0;
  const std::int64_t a = values.first + s;
  const std::int64_t b = values.second + t;
  if (s == t) {
    const bool first_is_farther = (a < b) == (s == 1);
    return {(first_is_farther ? a : b) - t, a - b - s};
  }
  const bool second_is_farther = (a + b < 0) == (t == 1);
  return {a + b - t, (second_is_farther ? -b : a) - s};
}

ValuePair rotate_back(const HaarPair& pair) {
  const auto [low, high] = pair;
  if (low >= 0 && -low <= high && high <= low) {  // both values at least 0
    return high >= 0 ? ValuePair{low, low - high} : ValuePair{low + high, low};
  }
  if (low < 0 && low <= high && high <= -low - 2) {  // both below 0
    return high < -1 ? ValuePair{low, low - high - 1} : ValuePair{low + high + 1, low};
  }
  if (high >= 0) {  // the second below 0
    return low < -1 ? ValuePair{low + high + 1, -high - 1} : ValuePair{high, low - high};
  }
  return low >= 0 ? ValuePair{low + high, -high - 1} : ValuePair{high, low - high - 1};  // the first below 0
}

}  // namespace

HaarPair haar_forward(const ValuePair& values) {
  auto [low, high] = rotate(values);
  // Of low to -low - 1 the next, of the last the first.
  if (low < 0 && low <= high && high < -low) high = high + 1 < -low ? high + 1 : low;
  return {low, high};
}

ValuePair haar_inverse(const HaarPair& pair) {
  auto [low, high] = pair;
  if (low < 0 && low <= high && high < -low) high = high > low ? high - 1 : -low - 1;
  return rotate_back({low, high});
}

void haar_analyze(std::span<std::int64_t> values) {
  for (std::size_t step = 1; step < values.size(); step *= 2)
    for (std::size_t i = 0; i + step < values.size(); i += 2 * step) {
      const HaarPair pair = haar_forward({values[i], values[i + step]});
      values[i] = pair.low;
      values[i + step] = pair.high;
    }
}

std::size_t last_haar_step(std::size_t count) { return count < 2 ? 0 : std::bit_floor(count - 1); }

}  // namespace colossus::codec::paper
