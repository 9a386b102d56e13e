// How far a vertex may still be moved, when all that it has swallowed must stay within reach.
#pragma once

#include <algorithm>
#include <cstdint>

#include "geometry/point.hpp"

namespace colossus::simplify {

// The bounding box of all vertices that have become one. In the maximum norm none of them is farther from a
// point than the box's farthest corner.
struct MergedBox {
  geometry::Point low;
  geometry::Point high;

  void add(const MergedBox& other) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
  }

  // Whether all of them are at most `reach` from p, in the maximum norm.
  bool is_within(std::int64_t reach, const geometry::Point& p) const {
    for (int axis = 0; axis < 3; ++axis)
      if (std::int64_t{p[axis]} - low[axis] > reach || std::int64_t{high[axis]} - p[axis] > reach)
        return false;
    return true;
  }
};

}  // namespace colossus::simplify
