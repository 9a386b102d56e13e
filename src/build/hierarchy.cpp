#include "build/hierarchy.hpp"

#include <algorithm>
#include <tuple>

namespace colossus::build {

void Hierarchy::add(const FinishedNode& node) {
  nodes.push_back(node);
  const container::NodeRow& row = node.row;
  if (levels.size() <= row.level) levels.resize(row.level + 1);
  LevelStatistics& level = levels[row.level];
  ++level.nodes;
  level.leaves += (row.flags & container::kNodeIsLeaf) != 0 ? 1 : 0;
  level.leaves_above_limit += (row.flags & container::kNodeIsAboveLimit) != 0 ? 1 : 0;
  level.vertices += row.vertices;
  level.triangles += row.triangles;
  level.payload_bytes += row.payload_bytes;
  level.stored_bytes += row.stored_bytes;
  level.error = std::max(level.error, row.error);
  level.displacement = std::max(level.displacement, node.displacement);
  for (std::size_t i = 0; i < codec::kComponentCount; ++i)
    level.component_bytes[i] += node.component_bytes[i];
  add(row.level, node.statistics);
}

void Hierarchy::add(std::uint32_t level, const NodeStatistics& own) {
  if (levels.size() <= level) levels.resize(level + 1);
  NodeStatistics& sums = levels[level].sums;
  sums.initial_triangles += own.initial_triangles;
  sums.target_triangles += own.target_triangles;
  sums.reached_triangles += own.reached_triangles;
  sums.initial_vertices += own.initial_vertices;
  sums.locked_vertices += own.locked_vertices;
  sums.angles.below_5_degrees += own.angles.below_5_degrees;
  sums.angles.below_15_degrees += own.angles.below_15_degrees;
  sums.angles.below_30_degrees += own.angles.below_30_degrees;
}

void Hierarchy::sort() {
  std::sort(nodes.begin(), nodes.end(), [](const StoredNode& a, const StoredNode& b) {
    return std::tie(a.row.level, a.row.center) < std::tie(b.row.level, b.row.center);
  });
}

}  // namespace colossus::build
