// One block of cubes as a task: from the cubes' meshes in scratch to their chunks, and to the meshes of their
// parents.
#pragma once

#include "codec/codec.hpp"
#include "pipeline/blocks/partition.hpp"
#include "pipeline/facts/finished_nodes.hpp"

namespace colossus::pipeline::blocks {

// A node as its task takes it.
struct BlockCube {
  CubeRecord record;
  double error = 0.0;  // world units
};

// The nodes of one block.
struct NodeTask {
  hierarchy::BlockId block;
  std::vector<BlockCube> cubes;          // of one level, in order
  std::vector<scratch::RecordRef> rims;  // of the cubes around the block

  core::Bytes to_bytes() const;
  static NodeTask from_bytes(std::span<const std::byte> bytes);
};

struct NodeResult {
  std::vector<facts::FinishedNode> nodes;  // the task's cubes
  std::vector<BlockCube> parents;          // none of level 0
  facts::NodeStatistics statistics;        // of making the parents
  std::int64_t farthest_parent = 0;        // of a vertex, in the maximum norm, on the lattice of 2^30

  core::Bytes to_bytes() const;
  static NodeResult from_bytes(std::span<const std::byte> bytes);
};

// What all blocks of a build share.
struct NodeSettings {
  geometry::Lattice lattice;
  Grid grid;
  const codec::Codec* codec = nullptr;
  int block_size = 0;  // cubes along a block
  bool has_shifted_blocks = true;
  bool has_colors = false;
  double color_weight = 0.0;    // see simplify::Region
  double rounding_error = 0.0;  // world units: by which the lattice and the grid have moved the vertices
  // By which the input has moved where splits have moved it by so much; world units.
  double input_error(double displacement) const { return rounding_error + displacement * lattice.step; }
  hierarchy::BlockId block_of(const hierarchy::CubeId& cube) const {
    return has_shifted_blocks ? hierarchy::block_of(cube, block_size)
                              : hierarchy::unshifted_block_of(cube, block_size);
  }
};

// An upper estimate of the memory of build_block(), per triangle of its cubes, and for so many of them: the
// meshes of the cubes stay while their region is simplified.
std::uint64_t bytes_per_triangle(bool weighs_colors);
std::uint64_t task_bytes(const NodeSettings& settings, std::uint64_t triangles);

// Simplifies the block to a quarter of its triangles with its border locked, splits the result into the
// parents along the map, and encodes the cubes with the map to their parents' vertices (Li 2024,
// sections 3.2.4 and 3.2.5). Cubes of level 0 are only encoded. Not collective; this is where the time of a
// build goes.
NodeResult build_block(const run::Workspace& workspace, const NodeSettings& settings, const NodeTask& task);

}  // namespace colossus::pipeline::blocks
