// Which stored error holds for a point of the input at a level; each scheme finds the nodes that stand for
// it.
#pragma once

#include <cstdint>
#include <vector>

#include "reader/access/statue.hpp"
#include "verify/measure/distance.hpp"

namespace colossus::verify::measure {

// Units of the builder's lattice of 2^30: half a cell of its input vertices on each axis is sqrt(3) * 4, each
// cut rounds by less than a unit, if not always in one direction, and far from the origin a sample's own
// coordinates are no finer than a cell.
inline constexpr double kRounding = 64.0;

struct HeldError {
  double error = 0.0;  // world units; the largest of the nodes that may stand for the point
  reader::access::RowIndex row = reader::access::kNoRow;  // that node; kNoRow when none stands for it
  bool is_known = true;                                   // false when one of these nodes is damaged
};

// In lattice units; within the root cube, as everything that the container stands for.
WorldPoint lattice_position(const container::LatticeInfo& lattice, const WorldPoint& p);

// Makes the row the one whose error holds if its error is larger.
void consider(const reader::access::Statue& statue, reader::access::RowIndex row,
              const std::vector<bool>& is_damaged, HeldError& held);

}  // namespace colossus::verify::measure
