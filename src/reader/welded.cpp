#include "reader/welded.hpp"

#include <algorithm>
#include <bit>

#include "core/hash.hpp"

namespace colossus::reader {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// For each vertex the first one with the same weights, which is the same position.
std::vector<std::uint32_t> first_with_same_weights(const std::vector<codec::Weights>& weights) {
  const std::size_t slots = std::bit_ceil(weights.size() * 2 + 1);
  std::vector<std::uint32_t> table(slots, kNone);
  std::vector<std::uint32_t> first(weights.size());
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    const codec::Weights& w = weights[i];
    // Each weight is at most 2^16 and they have one sum, so three of them are the key.
    const std::uint64_t key = std::uint64_t{w[0]} << 40 ^ std::uint64_t{w[1]} << 20 ^ w[2];
    std::size_t slot = core::mix64(key) & (slots - 1);
    while (table[slot] != kNone && weights[table[slot]] != w) slot = (slot + 1) & (slots - 1);
    if (table[slot] == kNone) table[slot] = i;
    first[i] = table[slot];
  }
  return first;
}

struct SortedTriangle {
  std::uint64_t low;   // the two smaller corners
  std::uint32_t high;  // the largest corner
  std::uint32_t index;
  bool is_even;
};

SortedTriangle sorted_triangle(const mesh::Triangle& t, std::uint32_t index) {
  mesh::Triangle s = t;
  bool is_even = true;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (s[j] < s[i]) {
      std::swap(s[i], s[j]);
      is_even = !is_even;
    }
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return {std::uint64_t{s[0]} << 32 | s[1], s[2], index, is_even};
}

bool have_same_corners(const SortedTriangle& a, const SortedTriangle& b) {
  return a.low == b.low && a.high == b.high;
}

}  // namespace

WeldedTetrahedron weld_positions(const codec::QuantizedTetrahedron& part,
                                 const hierarchy::Tetrahedron& tetrahedron) {
  const std::vector<std::uint32_t> first = first_with_same_weights(part.weights);
  WeldedTetrahedron welded;
  std::vector<std::uint32_t> renumbered(part.weights.size(), kNone);
  for (std::uint32_t i = 0; i < part.weights.size(); ++i) {
    if (first[i] != i) continue;
    renumbered[i] = static_cast<std::uint32_t>(welded.positions.size());
    welded.positions.push_back(codec::scaled_position(part.weights[i], tetrahedron));
    std::uint8_t zeros = 0;
    for (std::size_t corner = 0; corner < 4; ++corner)
      if (part.weights[i][corner] == 0) zeros = static_cast<std::uint8_t>(zeros | 1U << corner);
    welded.zero_weights.push_back(zeros);
    welded.sources.push_back(i);
  }
  welded.triangles.reserve(part.triangles.size());
  for (const mesh::Triangle& t : part.triangles) {
    const mesh::Triangle w{renumbered[first[t[0]]], renumbered[first[t[1]]], renumbered[first[t[2]]]};
    if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) welded.triangles.push_back(w);
  }
  cancel_opposite_triangles(welded.triangles);
  return welded;
}

void cancel_opposite_triangles(std::vector<mesh::Triangle>& triangles) {
  std::vector<SortedTriangle> entries;
  entries.reserve(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) entries.push_back(sorted_triangle(triangles[i], i));
  std::sort(entries.begin(), entries.end(), [](const SortedTriangle& a, const SortedTriangle& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.index < b.index;
  });
  std::vector<bool> is_cancelled;
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t end = i;
    std::size_t even = 0;
    for (; end < entries.size() && have_same_corners(entries[end], entries[i]); ++end)
      even += entries[end].is_even ? 1 : 0;
    const std::size_t pairs = std::min(even, end - i - even);
    if (pairs > 0) {
      if (is_cancelled.empty()) is_cancelled.resize(triangles.size());
      // From the last one backwards, so that the first ones remain.
      std::array<std::size_t, 2> left{pairs, pairs};
      for (std::size_t k = end; k-- > i;)
        if (std::size_t& count = left[entries[k].is_even ? 1 : 0]; count > 0) {
          is_cancelled[entries[k].index] = true;
          --count;
        }
    }
    i = end;
  }
  if (is_cancelled.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (!is_cancelled[i]) triangles[kept++] = triangles[i];
  triangles.resize(kept);
}

}  // namespace colossus::reader
