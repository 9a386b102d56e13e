// The blocks scheme: uncut triangles in the cubes of an octree, simplified block by block with half-edge
// collapses (Li 2024, chapter 3).
#pragma once

#include "pipeline/nodes/scheme.hpp"

namespace colossus::pipeline::blocks {

inline constexpr int kDefaultBlockSize = 4;
// Edges are at most this long in the maximum norm, in sides of a cube of the deepest level; likewise twice
// the way from a vertex to its parent, in sides of its cube. Viewers need kappa0 > 1 + 3 sigma0; half of that
// is interpolation band.
inline constexpr double kGreatestSigma = 0.3;

extern const nodes::Scheme kScheme;

}  // namespace colossus::pipeline::blocks
