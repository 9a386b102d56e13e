#include "geometry/octahedral.hpp"

#include <algorithm>
#include <cmath>

namespace colossus::geometry {

Normal16 to_normal16(double x, double y, double z) {
  const double length = std::sqrt(x * x + y * y + z * z);
  if (!(length > 0.0)) return {0, 0, 32767};
  const double scale = 32767.0 / length;
  return {static_cast<std::int16_t>(std::floor(x * scale + 0.5)),
          static_cast<std::int16_t>(std::floor(y * scale + 0.5)),
          static_cast<std::int16_t>(std::floor(z * scale + 0.5))};
}

std::array<double, 3> decode_octahedral(std::array<std::uint8_t, 2> code) {
  double x = code[0] / 127.5 - 1.0;
  double y = code[1] / 127.5 - 1.0;
  const double z = 1.0 - std::abs(x) - std::abs(y);
  if (z < 0.0) {
    const double folded_x = (1.0 - std::abs(y)) * (x >= 0.0 ? 1.0 : -1.0);
    const double folded_y = (1.0 - std::abs(x)) * (y >= 0.0 ? 1.0 : -1.0);
    x = folded_x;
    y = folded_y;
  }
  const double length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

std::array<std::uint8_t, 2> encode_octahedral(const Normal16& normal) {
  double x = normal[0];
  double y = normal[1];
  double z = normal[2];
  const double sum = std::abs(x) + std::abs(y) + std::abs(z);
  if (!(sum > 0.0)) return {128, 128};
  x /= sum;
  y /= sum;
  z /= sum;
  double u = x;
  double v = y;
  if (z < 0.0) {
    u = (1.0 - std::abs(y)) * (x >= 0.0 ? 1.0 : -1.0);
    v = (1.0 - std::abs(x)) * (y >= 0.0 ? 1.0 : -1.0);
  }
  const int base_u = std::clamp(static_cast<int>(std::floor((u + 1.0) * 127.5)), 0, 254);
  const int base_v = std::clamp(static_cast<int>(std::floor((v + 1.0) * 127.5)), 0, 254);
  std::array<std::uint8_t, 2> best{};
  double best_dot = -2.0;
  for (int corner = 0; corner < 4; ++corner) {
    const std::array<std::uint8_t, 2> code{static_cast<std::uint8_t>(base_u + (corner & 1)),
                                           static_cast<std::uint8_t>(base_v + (corner >> 1))};
    const auto n = decode_octahedral(code);
    const double dot = n[0] * x + n[1] * y + n[2] * z;
    if (dot > best_dot) {
      best_dot = dot;
      best = code;
    }
  }
  return best;
}

}  // namespace colossus::geometry
