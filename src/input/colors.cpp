#include "input/colors.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "input/source.hpp"

namespace colossus::input {
namespace {

constexpr double kMostUnit = 1.02;
constexpr double kMostByte = 255.0;

bool is_unit(const SourceInfo& info, const char* what, double greatest) {
  if (greatest <= kMostUnit) return true;
  if (greatest <= kMostByte) return false;
  core::fail(core::Status::kBadData,
             "{}: the greatest {} is {}; expected numbers from 0 to 1 (at most {}) or from 0 to {}",
             info.path.string(), what, greatest, kMostUnit, kMostByte);
}

}  // namespace

std::uint8_t color_from_byte(double value) {
  if (!(value > 0)) return 0;
  return static_cast<std::uint8_t>(std::min(value, 255.0) + 0.5);
}

std::uint8_t color_from_unit(double value) { return color_from_byte(value * 255); }

ColorScale scale_of(const SourceInfo& info, const Remarks& remarks) {
  return {is_unit(info, "colour", remarks.greatest_color),
          is_unit(info, "alpha of a colour", remarks.greatest_alpha)};
}

}  // namespace colossus::input
