#include "verify/blocks/held_error.hpp"

#include <algorithm>
#include <cmath>

namespace colossus::verify::blocks {

measure::HeldError held_error(const reader::blocks::Statue& statue, std::uint32_t level,
                              const measure::WorldPoint& p, const std::vector<bool>& is_damaged) {
  const measure::WorldPoint q = measure::lattice_position(statue.metadata().lattice, p);
  // No point of a triangle is farther from its barycentre than two thirds of its longest edge.
  const double reach = statue.longest_edge(static_cast<int>(statue.deepest_level())) * 2.0 / 3.0 + 1.0 +
                       std::ldexp(measure::kRounding, statue.root_bits() - geometry::kRootBits);
  const double cubes = std::ldexp(1.0, static_cast<int>(level));
  const double cubes_per_unit = std::ldexp(cubes, -statue.root_bits());
  std::array<std::int32_t, 3> low{};
  std::array<std::int32_t, 3> high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto index = [&](double c) {
      return static_cast<std::int32_t>(std::clamp(std::floor(c * cubes_per_unit), 0.0, cubes - 1.0));
    };
    low[axis] = index(q[axis] - reach);
    high[axis] = index(q[axis] + reach);
  }
  measure::HeldError held;
  for (std::int32_t x = low[0]; x <= high[0]; ++x)
    for (std::int32_t y = low[1]; y <= high[1]; ++y)
      for (std::int32_t z = low[2]; z <= high[2]; ++z)
        if (const reader::access::RowIndex row = statue.find({static_cast<std::int32_t>(level), x, y, z});
            row != reader::access::kNoRow)
          consider(statue, row, is_damaged, held);
  return held;
}

}  // namespace colossus::verify::blocks
