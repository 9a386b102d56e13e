// Private to this folder: lengths in units in which squares of squares neither overflow nor vanish.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "verify/measure/distance.hpp"

namespace colossus::verify::measure {

// Multiplies by a power of two, so that nothing is rounded: a statue may be 1e300 or 1e-300 wide.
class Scale {
 public:
  Scale() = default;
  // After it, `extent` is from 1 to below 2. Within 2^+-1000, so that both factors are ordinary doubles;
  // what is left of wider and narrower statues does no harm.
  explicit Scale(double extent) {
    if (!(extent > 0.0) || !std::isfinite(extent)) return;
    const int exponent = std::clamp(std::ilogb(extent), -1000, 1000);
    down_ = std::ldexp(1.0, -exponent);
    up_ = std::ldexp(1.0, exponent);
  }
  double scaled(double length) const { return length * down_; }
  WorldPoint scaled(const WorldPoint& p) const { return {p[0] * down_, p[1] * down_, p[2] * down_}; }
  double world(double length) const { return length * up_; }
  WorldPoint world(const WorldPoint& p) const { return {p[0] * up_, p[1] * up_, p[2] * up_}; }

 private:
  double down_ = 1.0;
  double up_ = 1.0;
};

}  // namespace colossus::verify::measure
