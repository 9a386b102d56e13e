// Private to this folder: which stored error holds for a point of the input at a level.
#pragma once

#include <cstdint>
#include <vector>

#include "reader/cube_statue.hpp"
#include "reader/distance.hpp"
#include "reader/statue.hpp"

namespace colossus::reader {

struct HeldError {
  double error = 0.0;     // world units; the largest of the nodes that may stand for the point
  RowIndex row = kNoRow;  // that node; kNoRow when none stands for it
  bool is_known = true;   // false when one of these nodes is damaged
};

// The nodes of the level's uniform cut whose tetrahedra contain the point, where the builder has moved it by
// at most the rounding to its lattice and that of cuts: a point nearer than this to a face may belong to
// either side. Quantisation may leave nothing of a sliver of the surface in a tetrahedron, which then has no
// row; for a point there those nodes count that are no farther away than their own error. Microseconds.
HeldError held_error(const Statue& statue, std::uint32_t level, const WorldPoint& p,
                     const std::vector<bool>& is_damaged);

// The cubes of the level that a triangle through the point can belong to: those of the deepest level that
// hold barycentres of triangles through it, whose edges sigma0 bounds, and their ancestors. Microseconds.
HeldError held_error(const CubeStatue& statue, std::uint32_t level, const WorldPoint& p,
                     const std::vector<bool>& is_damaged);

}  // namespace colossus::reader
