#include "codec/coded/frame.hpp"

#include <cstdlib>
#include <numeric>

#include "core/error.hpp"

namespace colossus::codec::coded {

Frame frame_of(const hierarchy::Tetrahedron& tetrahedron) {
  const auto entry = [&](std::size_t row, int axis) {
    return std::int64_t{tetrahedron.corners[row][axis]} - tetrahedron.corners[3][axis];
  };
  std::int64_t unit = 0;
  for (std::size_t row = 0; row < 3; ++row)
    for (int axis = 0; axis < 3; ++axis) unit = std::gcd(unit, entry(row, axis));
  Frame frame{};
  for (std::size_t row = 0; row < 3; ++row)
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t value = entry(row, axis) / unit;
      COLOSSUS_CHECK(std::abs(value) <= kGreatestFrameEntry, "an edge of {} units", value);
      frame[row][static_cast<std::size_t>(axis)] = static_cast<std::int8_t>(value);
    }
  return frame;
}

}  // namespace colossus::codec::coded
