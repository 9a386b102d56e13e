#include "pipeline/facts/finished_nodes.hpp"

#include <algorithm>
#include <tuple>

#include "core/error.hpp"
#include "core/log.hpp"
#include "pipeline/facts/level_table.hpp"

namespace colossus::pipeline::facts {

namespace {

// Every statistic has eight bytes.
constexpr std::size_t kSumBytes = [] {
  std::size_t bytes = 0;
  for_each_sum([&](const LevelField&, auto) { bytes += sizeof(std::uint64_t); });
  return bytes;
}();
static_assert(sizeof(NodeStatistics) == kSumBytes, "a sum is in no table");
constexpr std::size_t kLevelBytes = [] {
  std::size_t bytes = 0;
  for_each_level_field([&](const LevelField&, auto) { bytes += sizeof(std::uint64_t); });
  return bytes;
}();
static_assert(sizeof(LevelStatistics) == kLevelBytes, "a statistic of a level is in no table");

}  // namespace

NodeStatistics& NodeStatistics::operator+=(const NodeStatistics& other) {
  for_each_sum(
      [&](const LevelField&, auto member) { std::invoke(member, *this) += std::invoke(member, other); });
  return *this;
}

void FinishedNodes::add(const FinishedNode& node) {
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
  for (std::size_t i = 0; i < codec::coded::kComponentCount; ++i)
    level.component_bytes[i] += node.component_bytes[i];
  add(row.level, node.statistics);
}

void FinishedNodes::add(std::uint32_t level, const NodeStatistics& statistics) {
  if (levels.size() <= level) levels.resize(level + 1);
  levels[level].sums += statistics;
}

double FinishedNodes::finest_area() const {
  double sum = 0.0;
  for (const StoredNode& node : nodes) sum += node.area;
  return sum;
}

std::uint64_t FinishedNodes::finest_triangles() const {
  std::uint64_t sum = 0;
  for (const StoredNode& node : nodes)
    if ((node.row.flags & container::kNodeIsLeaf) != 0) sum += node.row.triangles;
  return sum;
}

void FinishedNodes::sort() {
  std::sort(nodes.begin(), nodes.end(), [](const StoredNode& a, const StoredNode& b) {
    return std::tie(a.row.level, a.row.center) < std::tie(b.row.level, b.row.center);
  });
}

void require_tolerance(const BuildOptions& options, double greatest_error) {
  if (!options.tolerance || greatest_error <= *options.tolerance) return;
  core::fail(core::Status::kUsage,
             "--tolerance {} cannot be kept: the least that can is {}, the greatest error of a leaf, where "
             "corners were moved apart that would have fallen together, or edges were split; smaller leaves "
             "(--leaf-triangles) allow less",
             *options.tolerance, greatest_error);
}

void warn_of_missed_target(const FinishedNodes& finished, std::uint32_t level) {
  if (level >= finished.levels.size()) return;
  const NodeStatistics& sums = finished.levels[level].sums;
  if (10 * sums.reached_triangles <= 11 * sums.target_triangles) return;
  core::warn(
      "level {} does not shrink as it should: {} triangles are left of {}, where {} were aimed at; separate "
      "pieces, borders, non-manifold edges and what other nodes share can be simplified only so far",
      level, sums.reached_triangles, sums.initial_triangles, sums.target_triangles);
}

}  // namespace colossus::pipeline::facts
