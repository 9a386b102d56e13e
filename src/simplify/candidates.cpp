#include "simplify/candidates.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace colossus::simplify {

void drop_costly(std::vector<Candidate>& candidates, std::size_t rank, float factor) {
  std::vector<float> costs;
  costs.reserve(candidates.size());
  for (const Candidate& candidate : candidates) costs.push_back(candidate.cost);
  std::nth_element(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(rank), costs.end());
  const float limit = factor * costs[rank];
  std::erase_if(candidates, [&](const Candidate& candidate) { return candidate.cost > limit; });
}

void sort_by_cost(std::vector<Candidate>& candidates, std::vector<Candidate>& scratch) {
  // By radix: the bits of floats that are not negative are in order.
  constexpr int kDigitBits = 11;
  constexpr std::uint32_t kDigits = 1U << kDigitBits;
  scratch.resize(candidates.size());
  for (int shift = 0; shift < 32; shift += kDigitBits) {
    std::array<std::uint32_t, kDigits> starts{};
    const auto digit = [&](const Candidate& c) {
      return std::bit_cast<std::uint32_t>(c.cost) >> shift & (kDigits - 1);
    };
    for (const Candidate& candidate : candidates) ++starts[digit(candidate)];
    std::uint32_t sum = 0;
    for (auto& start : starts) sum += std::exchange(start, sum);
    for (const Candidate& candidate : candidates) scratch[starts[digit(candidate)]++] = candidate;
    candidates.swap(scratch);
  }
}

}  // namespace colossus::simplify
