#include "codec/coded/places.hpp"

#include <algorithm>
#include <bit>

#include "core/hash.hpp"

namespace colossus::codec::coded {

std::size_t WeightsHash::operator()(const Weights& w) const {
  // Each weight is at most 2^16 and they have one sum, so three of them are the key.
  return core::mix64(std::uint64_t{w[0]} << 40 ^ std::uint64_t{w[1]} << 20 ^ w[2]);
}

std::size_t face_count(const Weights& weights) {
  return static_cast<std::size_t>(std::count(weights.begin(), weights.end(), 0U));
}

bool share_face(const Weights& a, const Weights& b) {
  for (std::size_t corner = 0; corner < 4; ++corner)
    if (a[corner] == 0 && b[corner] == 0) return true;
  return false;
}

std::vector<std::uint32_t> first_at_place(const std::vector<Weights>& weights) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  const std::size_t slots = std::bit_ceil(weights.size() * 2 + 1);
  std::vector<std::uint32_t> table(slots, kNone);
  std::vector<std::uint32_t> first(weights.size());
  for (std::uint32_t v = 0; v < weights.size(); ++v) {
    std::size_t slot = WeightsHash{}(weights[v]) & (slots - 1);
    while (table[slot] != kNone && weights[table[slot]] != weights[v]) slot = (slot + 1) & (slots - 1);
    if (table[slot] == kNone) table[slot] = v;
    first[v] = table[slot];
  }
  return first;
}

bool step_aside(std::uint32_t v, std::vector<Weights>& weights, Places& places) {
  constexpr std::uint32_t kMostUnits = 8;
  for (std::uint32_t units = 1; units <= kMostUnits; ++units)
    for (std::size_t to = 0; to < 4; ++to)
      for (std::size_t from = 0; from < 4; ++from) {
        Weights moved = weights[v];
        if (to == from || moved[from] <= units || moved[to] == 0) continue;
        moved[to] += units;
        moved[from] -= units;
        if (!places.try_emplace(moved, v).second) continue;
        weights[v] = moved;
        return true;
      }
  return false;
}

Weights middle_of(const Weights& a, const Weights& b) {
  Weights middle{};
  bool rounds_up = false;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint32_t sum = a[i] + b[i];
    middle[i] = sum / 2;
    if (sum % 2 == 0) continue;
    middle[i] += rounds_up ? 1 : 0;
    rounds_up = !rounds_up;
  }
  for (std::size_t i = 0; i < 4; ++i)
    if (middle[i] == 0 && a[i] + b[i] > 0) {
      --*std::max_element(middle.begin(), middle.end());
      middle[i] = 1;
    }
  return middle;
}

Weights off_faces(Weights weights) {
  for (auto& weight : weights)
    if (weight == 0) {
      --*std::max_element(weights.begin(), weights.end());
      weight = 1;
    }
  return weights;
}

}  // namespace colossus::codec::coded
