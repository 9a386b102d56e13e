// Integer coordinates in which prediction is at its best: along short directions that are nearly at right
// angles, where barycentric weights run along the edges of a flat tetrahedron.
#pragma once

#include <algorithm>
#include <bit>

#include "codec/coded/coded_node.hpp"

namespace colossus::codec::predict {

using Vector = std::array<std::int32_t, 3>;
using LongVector = std::array<std::int64_t, 3>;
using Matrix = std::array<Vector, 3>;

// Wherever bytes of no sense could lead out of range, arithmetic wraps.
constexpr std::int32_t wrapped_sum(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}
constexpr std::int32_t wrapped_difference(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}
constexpr std::int64_t wrapped_sum(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}
constexpr std::int64_t wrapped_product(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) * static_cast<std::uint64_t>(b));
}
constexpr std::int64_t wrapped_difference(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}
constexpr std::int32_t wrapped_dot(const Vector& a, const Vector& b) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    sum += static_cast<std::uint32_t>(a[i]) * static_cast<std::uint32_t>(b[i]);
  return static_cast<std::int32_t>(sum);
}

// How many bits more than these the numbers have, signs apart.
constexpr int excess_bits(std::int64_t x, std::int64_t y, std::int64_t z, int bits) {
  const auto size = static_cast<std::uint64_t>((x ^ x >> 63) | (y ^ y >> 63) | (z ^ z >> 63));
  return std::max(0, static_cast<int>(std::bit_width(size)) - bits);
}

// To the nearest, halves up. The denominator is positive, the numerator below 2^61.
constexpr std::int64_t rounded_quotient(std::int64_t numerator, std::int64_t denominator) {
  const std::int64_t twice = 2 * numerator + denominator;
  const std::int64_t quotient = twice / (2 * denominator);
  return quotient - (twice % (2 * denominator) < 0 ? 1 : 0);
}

struct Basis {
  Matrix from_weights;  // q = from_weights * (w0, w1, w2); the determinant is 1 or -1
  Matrix to_weights;
  Matrix to_world;  // rows: up to a common factor
  // Of the inverse of the scalar products of the directions: how gradients become directions.
  Matrix metric;
};

// The shortest independent combinations, with factors -1, 0 and 1, of the frame's rows.
Basis basis_of(const coded::Frame& frame);

}  // namespace colossus::codec::predict
