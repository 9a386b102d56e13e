// Colours as files have them, and as we keep them: RGBA bytes.
#pragma once

#include <array>
#include <cstdint>

#include "input/remarks.hpp"

namespace colossus::input {

struct SourceInfo;

using Color = std::array<std::uint8_t, 4>;
inline constexpr Color kNoColor{255, 255, 255, 255};  // what has none becomes white

// A colour component of 0 to 1 as a byte, rounded and clamped; NaN becomes 0.
std::uint8_t color_from_unit(double value);
// A colour component of 0 to 255 as a byte, rounded and clamped; NaN becomes 0.
std::uint8_t color_from_byte(double value);

// One colour. Whether floats are from 0 to 1 or from 0 to 255 no single value tells, so both readings are
// kept; components whose scale is known are equal in both.
struct ReadColor {
  Color unit = kNoColor;
  Color byte = kNoColor;

  // Component `k` of 0 to 3, of unknown scale; a number.
  void set(std::size_t k, double value) {
    unit[k] = color_from_unit(value);
    byte[k] = color_from_byte(value);
  }
  void set_known(std::size_t k, std::uint8_t value) { unit[k] = byte[k] = value; }
};

// Which reading of a file's colours is right. Alpha has a scale of its own: 0 to 255 for colours beside 0 to
// 1 for alpha occurs.
struct ColorScale {
  bool is_color_unit = true;
  bool is_alpha_unit = true;

  Color pick(const Color& unit, const Color& byte) const {
    const Color& color = is_color_unit ? unit : byte;
    return {color[0], color[1], color[2], (is_alpha_unit ? unit : byte)[3]};
  }
};

// By the greatest of all values of a file: at most 1.02 (exporters overshoot, by 1.003922 or so) means 0 to
// 1, at most 255 means 0 to 255. Throws core::Error(kBadData) for greater ones.
ColorScale scale_of(const SourceInfo& info, const Remarks& remarks);

}  // namespace colossus::input
