// Private to this folder: which stored error of diamonds holds for a point of the input at a level.
#pragma once

#include "reader/diamonds/statue.hpp"
#include "verify/measure/held_error.hpp"

namespace colossus::verify::diamonds {

// The nodes of the level's uniform cut whose tetrahedra contain the point, where the builder has moved it by
// at most the rounding to its lattice and that of cuts: a point nearer than this to a face may belong to
// either side. Quantisation may leave nothing of a sliver of the surface in a tetrahedron, which then has no
// row; for a point there those nodes count that are no farther away than their own error. Microseconds.
measure::HeldError held_error(const reader::diamonds::Statue& statue, std::uint32_t level,
                              const measure::WorldPoint& p, const std::vector<bool>& is_damaged);

}  // namespace colossus::verify::diamonds
