#include "build/diamonds/levels.hpp"

#include <algorithm>
#include <map>
#include <unordered_map>

#include "build/phase.hpp"
#include "core/log.hpp"

namespace colossus::build {
namespace {

using core::Bytes;
using hierarchy::Diamond;
using hierarchy::Point;
using hierarchy::TetrahedronId;

class LevelBuilder {
 public:
  LevelBuilder(const Workspace& workspace, const NodeSettings& settings, const Partition& partition)
      : workspace_(workspace), settings_(settings), splits_(partition.splits) {
    if (!workspace_.ranks.is_root()) return;
    for (const TetrahedronRecord& leaf : partition.leaves) {
      tetrahedra_.emplace(leaf.id, leaf);
      leaves_[leaf.id.center].push_back(leaf);
    }
    for (const Point& center : splits_) splits_by_level_[hierarchy::level_of(center)].push_back(center);
    for (auto& [level, centers] : splits_by_level_) std::sort(centers.begin(), centers.end());
  }

  Hierarchy run() {
    run_tasks(leaf_tasks(), "leaves");
    std::int64_t levels = splits_by_level_.empty() ? 0 : splits_by_level_.rbegin()->first + 1;
    broadcast_value(workspace_.ranks, levels);
    for (auto level = static_cast<int>(levels) - 1; level >= 0; --level)
      run_tasks(inner_tasks(level), fmt::format("level {}", level));
    hierarchy_.sort();
    return std::move(hierarchy_);
  }

 private:
  std::vector<NodeTask> leaf_tasks() const {
    std::vector<NodeTask> tasks;
    for (const auto& [center, members] : leaves_) {
      NodeTask task;
      task.center = center;
      task.is_leaf = true;
      for (const TetrahedronRecord& leaf : members)
        task.parts.push_back({leaf.id.place, 0, leaf.triangles, 0, leaf.record});
      tasks.push_back(std::move(task));
    }
    return tasks;
  }

  std::vector<NodeTask> inner_tasks(int level) const {
    std::vector<NodeTask> tasks;
    const auto found = splits_by_level_.find(level);
    if (found == splits_by_level_.end()) return tasks;
    for (const Point& center : found->second) {
      NodeTask task = inner_task(center);
      if (!task.parts.empty()) tasks.push_back(std::move(task));
    }
    return tasks;
  }

  NodeTask inner_task(const Point& center) const {
    const Diamond diamond = Diamond::at(center);
    NodeTask task;
    task.center = center;
    for (int place = 0; place < diamond.place_count; ++place) {
      if (!diamond.is_inside[static_cast<std::size_t>(place)]) continue;
      for (const int end : {0, 1}) {
        const TetrahedronId child =
            hierarchy::id_of(diamond.tetrahedra[static_cast<std::size_t>(place)].child(end));
        // A child counts even when only its other tetrahedra hold geometry: errors grow from every node to
        // its parents.
        if (const auto error = errors_.find(child.center); error != errors_.end())
          task.least_error = std::max(task.least_error, error->second);
        const auto entry = tetrahedra_.find(child);
        if (entry == tetrahedra_.end()) continue;
        task.parts.push_back({static_cast<std::uint32_t>(place), static_cast<std::uint32_t>(end),
                              entry->second.triangles, 0, entry->second.record});
      }
    }
    return task;
  }

  static std::uint64_t cost_of(const NodeTask& task) {
    std::uint64_t triangles = 0;
    for (const NodePart& part : task.parts) triangles += part.triangles;
    return triangles;
  }

  // Collective; tasks and results are on rank 0.
  void run_tasks(std::vector<NodeTask> tasks, const std::string& name) {
    // The largest first, so that none of them starts last.
    std::stable_sort(tasks.begin(), tasks.end(),
                     [](const NodeTask& a, const NodeTask& b) { return cost_of(a) > cost_of(b); });
    std::vector<NodeResult> results(tasks.size());
    run_phase(
        workspace_, name, tasks.size(), [&](std::size_t i) { return tasks[i].to_bytes(); },
        [&](std::span<const std::byte> bytes) {
          return build_node(workspace_, settings_, NodeTask::from_bytes(bytes)).to_bytes();
        },
        [&](std::size_t i, Bytes bytes) { results[i] = NodeResult::from_bytes(bytes); });
    std::uint64_t triangles = 0;
    for (const NodeResult& result : results) {
      take(result);
      triangles += result.node.row.triangles;
    }
    core::log("{}: {} nodes, {} triangles, peak memory {} MB", name, tasks.size(), triangles,
              core::peak_memory_bytes() >> 20);
  }

  void take(const NodeResult& result) {
    const container::NodeRow& row = result.node.row;
    errors_[{row.center[0], row.center[1], row.center[2]}] = row.error;
    for (const TetrahedronRecord& record : result.tetrahedra) tetrahedra_.insert_or_assign(record.id, record);
    hierarchy_.add(result.node);
  }

  const Workspace& workspace_;
  const NodeSettings& settings_;
  const DiamondSet& splits_;
  std::map<Point, std::vector<TetrahedronRecord>> leaves_;
  std::map<int, std::vector<Point>> splits_by_level_;
  std::unordered_map<TetrahedronId, TetrahedronRecord, hierarchy::TetrahedronIdHash> tetrahedra_;
  std::unordered_map<Point, double, geometry::PointHash> errors_;
  Hierarchy hierarchy_;
};

}  // namespace

Hierarchy build_levels(const Workspace& workspace, const NodeSettings& settings, const Partition& partition) {
  return LevelBuilder(workspace, settings, partition).run();
}

}  // namespace colossus::build
