// Phases 4 and 5: encodes the leaves, then simplifies level by level from the finest to the root.
#pragma once

#include "build/node.hpp"
#include "build/partition.hpp"

namespace colossus::build {

struct LevelStatistics {
  std::uint64_t nodes = 0;
  std::uint64_t leaves = 0;
  std::uint64_t leaves_above_limit = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t payload_bytes = 0;
  std::uint64_t stored_bytes = 0;
  double error = 0.0;         // greatest of the level's nodes, world units
  double displacement = 0.0;  // greatest by quantisation
  NodeStatistics sums;
};

struct FinishedNode {
  container::NodeRow row;
  scratch::RecordRef chunk;
};

// On rank 0; empty on the others.
struct Hierarchy {
  std::vector<FinishedNode> nodes;      // ordered by level and centre
  std::vector<LevelStatistics> levels;  // from the root on
};

// Collective. Within a level nodes are independent tasks.
Hierarchy build_levels(const Workspace& workspace, const NodeSettings& settings, const Partition& partition);

}  // namespace colossus::build
