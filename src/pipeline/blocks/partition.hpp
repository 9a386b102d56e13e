// The step partition: chooses the deepest level of the octree, and puts the input's triangles into its cubes
// (Li 2024, section 3.2.3).
#pragma once

#include "pipeline/blocks/cube_store.hpp"
#include "pipeline/buckets/attributes.hpp"

namespace colossus::pipeline::blocks {

// The deepest level that is chosen: occupied cubes are counted exactly down to it.
inline constexpr int kDeepestCountedLevel = 10;

struct Grid {
  std::int32_t levels = 0;         // the deepest level
  std::int32_t position_bits = 0;  // per axis and side of a cube of the deepest level
  std::int32_t root_bits() const { return levels + position_bits; }
  // Positions are multiples of this, on the lattice of 2^30.
  std::int32_t spacing() const { return std::int32_t{1} << (geometry::kRootBits - root_bits()); }
  // The longest edge that need not be split, in the maximum norm.
  std::int64_t longest_edge() const;
};

// The smallest level with on average at most --leaf-triangles per cube that is not empty; lowered while more
// than one triangle in a hundred has an edge that is too long for its cubes. --levels overrides it.
// Throws Error(kUsage) when --tolerance cannot be kept. Collective.
Grid choose_grid(const run::Workspace& workspace, const facts::Catalog& catalog,
                 std::span<const ingest::TriangleGroup> groups);

struct Partition {
  std::vector<CubeRecord> cubes;  // on rank 0, in order
  double displacement = 0.0;      // the greatest of them
  std::int64_t longest_edge = 0;  // the maximum norm, on the lattice of 2^30; on rank 0
};

// Assigns each triangle to the cube that holds its barycentre. Edges that are too long are split at their
// middles, rounded to the grid, first, which depends on nothing but their ends, and counted. Positions are
// rounded to the grid. Fills the catalogue's area and counts. Collective.
Partition partition(const run::Workspace& workspace, facts::Catalog& catalog, const Grid& grid,
                    std::vector<ingest::TriangleGroup>&& groups);

}  // namespace colossus::pipeline::blocks
