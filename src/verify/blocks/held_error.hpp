// Private to this folder: which stored error of blocks holds for a point of the input at a level.
#pragma once

#include "reader/blocks/statue.hpp"
#include "verify/measure/held_error.hpp"

namespace colossus::verify::blocks {

// The cubes of the level that a triangle through the point can belong to: those of the deepest level that
// hold barycentres of triangles through it, whose edges sigma0 bounds, and their ancestors. Microseconds.
measure::HeldError held_error(const reader::blocks::Statue& statue, std::uint32_t level,
                              const measure::WorldPoint& p, const std::vector<bool>& is_damaged);

}  // namespace colossus::verify::blocks
