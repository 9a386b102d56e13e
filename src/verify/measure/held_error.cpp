#include "verify/measure/held_error.hpp"

#include <algorithm>
#include <cmath>

namespace colossus::verify::measure {

WorldPoint lattice_position(const container::LatticeInfo& lattice, const WorldPoint& p) {
  WorldPoint q{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    q[axis] =
        std::clamp((p[axis] - lattice.origin[axis]) / lattice.step, 0.0, std::ldexp(1.0, lattice.root_bits));
  return q;
}

void consider(const reader::access::Statue& statue, reader::access::RowIndex row,
              const std::vector<bool>& is_damaged, HeldError& held) {
  if (is_damaged[row]) held.is_known = false;
  const double error = statue.rows()[row].error;
  if (held.row != reader::access::kNoRow && !(error > held.error)) return;
  held.error = error;
  held.row = row;
}

}  // namespace colossus::verify::measure
