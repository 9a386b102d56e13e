// The blocks scheme: uncut triangles in the cubes of an octree, simplified block by block with half-edge
// collapses (Li 2024, chapter 3).
#pragma once

#include <optional>

#include "pipeline/nodes/scheme.hpp"

namespace colossus::pipeline::blocks {

inline constexpr int kDefaultBlockSize = 4;
// Edges are at most this long in the maximum norm, in sides of a cube of the deepest level; likewise twice
// the way from a vertex to its parent, in sides of its cube. Viewers need kappa0 > 1 + 3 sigma0; half of that
// is interpolation band.
inline constexpr double kGreatestSigma = 0.3;

extern const nodes::Scheme kScheme;

// What a user asks of blocks alone; see the table of options in scheme.cpp.
struct Options {
  std::optional<std::int64_t> levels;
  std::int64_t block_size;
  double color_weight;  // see simplify::Region
  // False: the borders of all levels lie on top of each other. For tests/bench/clefts, which shows what
  // shifting is for; no option of the program, and not known to readers.
  bool has_shifted_blocks;
};
Options options_of(const facts::BuildOptions& options);

}  // namespace colossus::pipeline::blocks
