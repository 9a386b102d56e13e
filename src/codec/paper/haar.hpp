// The reversible n-bit to n-bit Haar-like transform: Senecal, Lindstrom, Duchaineau, Joy, "An improved N-bit
// to N-bit reversible Haar-like transform" (2004). A rotation of the square of all pairs by 45 degrees in the
// maximum norm, exact on integers, so that both results have as many bits as both values.
//
// One departure. The square has no middle; where the low-pass value is negative, the published transform
// makes -1 of the difference of equal values. There one cyclic step of the differences puts it at 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace colossus::codec::paper {

inline constexpr int kMaxTransformBits = 33;

// Signed numbers of n bits, all four: from -2^(n-1) to 2^(n-1) - 1.
struct HaarPair {
  std::int64_t low = 0;   // near both values
  std::int64_t high = 0;  // their difference, if they have one sign
  friend bool operator==(const HaarPair&, const HaarPair&) = default;
};
struct ValuePair {
  std::int64_t first = 0;
  std::int64_t second = 0;
  friend bool operator==(const ValuePair&, const ValuePair&) = default;
};

HaarPair haar_forward(const ValuePair& values);
ValuePair haar_inverse(const HaarPair& pair);

// What is left of a stream of values when the low-pass values of neighbours are transformed again and again:
// one approximation at index 0, and the difference that was made with step s (1, 2, 4 ...) at the odd
// multiples of s. Linear.
void haar_analyze(std::span<std::int64_t> values);

// The largest power of two below `count`, or 0: the step with which haar_analyze() ends.
std::size_t last_haar_step(std::size_t count);

// Calls difference(step, low) for each difference, those of the largest step first, and makes of them and of
// values[0], the approximation, the values that haar_analyze() began with. Linear.
template <typename Difference>
void haar_synthesize(std::span<std::int64_t> values, Difference&& difference) {
  for (std::size_t step = last_haar_step(values.size()); step > 0; step /= 2)
    for (std::size_t i = 0; i + step < values.size(); i += 2 * step) {
      const ValuePair pair = haar_inverse({values[i], difference()});
      values[i] = pair.first;
      values[i + step] = pair.second;
    }
}

}  // namespace colossus::codec::paper
