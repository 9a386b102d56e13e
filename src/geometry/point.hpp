// Points of the integer lattice and boxes of doubles.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/hash.hpp"

namespace colossus::geometry {

// The root cube spans [0, kRootSide] on each axis, in lattice units.
inline constexpr int kRootBits = 30;
inline constexpr std::int32_t kRootSide = std::int32_t{1} << kRootBits;

// A position on the lattice. Ordered lexicographically by x, y, z: the one global order of corners and ends.
struct Point {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  std::int32_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  std::int32_t& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  friend auto operator<=>(const Point&, const Point&) = default;
};

struct PointHash {
  std::size_t operator()(const Point& p) const {
    const auto x = static_cast<std::uint32_t>(p.x);
    const auto y = static_cast<std::uint32_t>(p.y);
    const auto z = static_cast<std::uint32_t>(p.z);
    return core::mix64((std::uint64_t{x} << 32 | y) ^ core::mix64(z + 0x9e3779b97f4a7c15ULL));
  }
};

// Squared distance in lattice units; at most 3 * 2^60, which fits.
inline std::int64_t squared_distance(const Point& a, const Point& b) {
  const std::int64_t dx = std::int64_t{a.x} - b.x;
  const std::int64_t dy = std::int64_t{a.y} - b.y;
  const std::int64_t dz = std::int64_t{a.z} - b.z;
  return dx * dx + dy * dy + dz * dz;
}

// The midpoint of two corners whose coordinates have even sums.
inline Point midpoint(const Point& a, const Point& b) {
  return {static_cast<std::int32_t>((std::int64_t{a.x} + b.x) / 2),
          static_cast<std::int32_t>((std::int64_t{a.y} + b.y) / 2),
          static_cast<std::int32_t>((std::int64_t{a.z} + b.z) / 2)};
}

// An axis-parallel box in world units; empty until something is added.
struct Bounds {
  std::array<double, 3> low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::infinity()};
  std::array<double, 3> high{-std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()};
  bool is_empty() const { return low[0] > high[0]; }
  bool contains(const std::array<double, 3>& p) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!(p[axis] >= low[axis] && p[axis] <= high[axis])) return false;
    return true;
  }
  // The longest side; 0 when empty. Infinite where the difference is beyond a double.
  double extent() const {
    double longest = 0.0;
    for (std::size_t axis = 0; axis < 3 && !is_empty(); ++axis)
      longest = std::max(longest, high[axis] - low[axis]);
    return longest;
  }
  void merge(const Bounds& other) {
    if (other.is_empty()) return;
    add(other.low);
    add(other.high);
  }
  void add(const std::array<double, 3>& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
};

}  // namespace colossus::geometry
