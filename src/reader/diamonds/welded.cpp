#include "reader/diamonds/welded.hpp"

#include <bit>

#include "core/hash.hpp"

namespace colossus::reader::diamonds {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// For each vertex the first one with the same weights, which is the same position.
std::vector<std::uint32_t> first_with_same_weights(const std::vector<codec::coded::Weights>& weights) {
  const std::size_t slots = std::bit_ceil(weights.size() * 2 + 1);
  std::vector<std::uint32_t> table(slots, kNone);
  std::vector<std::uint32_t> first(weights.size());
  for (std::uint32_t i = 0; i < weights.size(); ++i) {
    const codec::coded::Weights& w = weights[i];
    // Each weight is at most 2^16 and they have one sum, so three of them are the key.
    const std::uint64_t key = std::uint64_t{w[0]} << 40 ^ std::uint64_t{w[1]} << 20 ^ w[2];
    std::size_t slot = core::mix64(key) & (slots - 1);
    while (table[slot] != kNone && weights[table[slot]] != w) slot = (slot + 1) & (slots - 1);
    if (table[slot] == kNone) table[slot] = i;
    first[i] = table[slot];
  }
  return first;
}

}  // namespace

WeldedTetrahedron weld_positions(const codec::coded::CodedPart& part,
                                 const hierarchy::Tetrahedron& tetrahedron) {
  const std::vector<std::uint32_t> first = first_with_same_weights(part.positions);
  WeldedTetrahedron welded;
  std::vector<std::uint32_t> renumbered(part.positions.size(), kNone);
  for (std::uint32_t i = 0; i < part.positions.size(); ++i) {
    if (first[i] != i) continue;
    renumbered[i] = static_cast<std::uint32_t>(welded.positions.size());
    welded.positions.push_back(codec::coded::scaled_position(part.positions[i], tetrahedron));
    welded.zero_weights.push_back(codec::coded::marks_of(part.positions[i]));
    welded.sources.push_back(i);
  }
  welded.triangles.reserve(part.triangles.size());
  for (const mesh::Triangle& t : part.triangles) {
    const mesh::Triangle w{renumbered[first[t[0]]], renumbered[first[t[1]]], renumbered[first[t[2]]]};
    if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) welded.triangles.push_back(w);
  }
  return welded;
}

}  // namespace colossus::reader::diamonds
