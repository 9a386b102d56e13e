// Positions within a tetrahedron: barycentric weights, and what follows from them alone.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "codec/coded/coded_node.hpp"
#include "hierarchy/diamond.hpp"

namespace colossus::codec::coded {

inline constexpr int kMinPositionBits = 8;
inline constexpr int kMaxPositionBits = 16;
inline constexpr int kDefaultPositionBits = 12;

// Weights of the four corners in global order; they sum to 2^position_bits.
using Weights = Coordinates;

// Bit i: weight i is 0, so the vertex lies on the face opposite corner i.
inline std::uint8_t marks_of(const Weights& weights) {
  std::uint8_t marks = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (weights[i] == 0) marks = static_cast<std::uint8_t>(marks | 1U << i);
  return marks;
}

// Of each vertex, for whoever asks for them more often than once.
inline std::vector<std::uint8_t> marks_of(const std::vector<Weights>& weights) {
  std::vector<std::uint8_t> marks(weights.size());
  for (std::size_t v = 0; v < marks.size(); ++v) marks[v] = marks_of(weights[v]);
  return marks;
}

// A decoded position times 2^position_bits, exact in 64 bits.
using ScaledPosition = std::array<std::int64_t, 3>;

inline ScaledPosition scaled_position(const Weights& weights, const hierarchy::Tetrahedron& tetrahedron) {
  ScaledPosition sum{};
  for (std::size_t i = 0; i < 4; ++i)
    for (int axis = 0; axis < 3; ++axis)
      sum[static_cast<std::size_t>(axis)] += std::int64_t{weights[i]} * tetrahedron.corners[i][axis];
  return sum;
}

}  // namespace colossus::codec::coded
