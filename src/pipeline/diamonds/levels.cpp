#include "pipeline/diamonds/levels.hpp"

#include <algorithm>
#include <map>

#include "pipeline/nodes/level_driver.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using core::Bytes;
using hierarchy::Diamond;
using hierarchy::Point;
using hierarchy::TetrahedronId;

class LevelBuilder {
 public:
  LevelBuilder(const run::Workspace& workspace, const NodeSettings& settings, const Partition& partition,
               facts::Catalog& catalog)
      : workspace_(workspace),
        driver_(workspace),
        settings_(settings),
        partition_(partition),
        catalog_(catalog),
        leaves_(partition.leaves) {
    driver_.finished().lattice = {settings.lattice.origin, settings.lattice.step, geometry::kRootBits};
    driver_.finished().position_bits = settings.quantize.position_bits;
    if (!workspace_.ranks.is_root()) return;
    for (const Point& center : partition.splits)
      splits_by_level_[hierarchy::level_of(center)].push_back(center);
    for (auto& [level, centers] : splits_by_level_) std::sort(centers.begin(), centers.end());
  }

  facts::FinishedNodes run() {
    run_tasks(
        "leaves", leaf_tasks(), [&](std::size_t first) { return leaf_task(first); }, std::nullopt);
    driver_.finish_finest(catalog_, [&] { count_leaves(); });
    std::int64_t levels = splits_by_level_.empty() ? 0 : splits_by_level_.rbegin()->first + 1;
    broadcast_value(workspace_.ranks, levels);
    // Leaves lie at several levels; their scratch goes with the one of the coarsest.
    std::int64_t coarsest_leaf = leaves_.empty() ? 0 : hierarchy::level_of(leaves_.front().id.center);
    broadcast_value(workspace_.ranks, coarsest_leaf);
    for (auto level = static_cast<int>(levels) - 1; level >= 0; --level) {
      run_level(level);
      // The level below, or the leaves' own phase, which keeps all it makes.
      release_phases(workspace_, last_phase(workspace_) - 1, last_phase(workspace_) - 1);
      if (level + 1 == coarsest_leaf)
        release_phases(workspace_, partition_.first_phase, partition_.last_phase);
    }
    return driver_.take();
  }

 private:
  using PlannedTask = nodes::PlannedTask;
  struct NodeError {
    Point center;
    double error = 0.0;
  };

  // Leaves are ordered by level, centre, place: those of a diamond follow each other.
  std::vector<PlannedTask> leaf_tasks() const {
    std::vector<PlannedTask> tasks;
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      if (i == 0 || leaves_[i].id.center != leaves_[i - 1].id.center) tasks.push_back({i, 0});
      tasks.back().triangles += leaves_[i].triangles;
    }
    return tasks;
  }

  NodeTask leaf_task(std::size_t first) const {
    NodeTask task;
    task.center = leaves_[first].id.center;
    task.is_leaf = true;
    for (std::size_t i = first; i < leaves_.size() && leaves_[i].id.center == task.center; ++i)
      task.parts.push_back({leaves_[i].id.place, 0, leaves_[i].triangles, 0, leaves_[i].record});
    return task;
  }

  void count_leaves() {
    for (const facts::LevelStatistics& level : driver_.finished().levels) {
      catalog_.counts.finest_border_edges += level.sums.finest_border_edges;
      catalog_.counts.finest_nonmanifold_edges += level.sums.finest_nonmanifold_edges;
    }
  }

  void run_level(int level) {
    take_children(level + 1);
    const std::vector<Point>& centers = splits_by_level_[level];
    std::vector<PlannedTask> tasks;
    for (std::size_t i = 0; i < centers.size(); ++i) {
      const NodeTask task = inner_task(centers[i]);
      if (!task.parts.empty()) tasks.push_back({i, cost_of(task)});
    }
    run_tasks(
        fmt::format("level {}", level), std::move(tasks),
        [&](std::size_t i) { return inner_task(centers[i]); }, static_cast<std::uint32_t>(level));
    splits_by_level_.erase(level);
  }

  // What the nodes of a level have left for those above it. What these have used is dropped.
  void take_children(int level) {
    children_ = std::move(made_);
    made_.clear();
    const auto is_above = [](const TetrahedronRecord& leaf, int l) {
      return hierarchy::level_of(leaf.id.center) < l;
    };
    const auto begin = std::lower_bound(leaves_.begin(), leaves_.end(), level, is_above);
    const auto end = std::lower_bound(begin, leaves_.end(), level + 1, is_above);
    children_.insert(children_.end(), begin, end);
    std::sort(children_.begin(), children_.end(),
              [](const TetrahedronRecord& a, const TetrahedronRecord& b) { return a.id < b.id; });
    errors_ = std::move(errors_by_level_[level]);
    errors_by_level_.erase(level);
    std::sort(errors_.begin(), errors_.end(),
              [](const NodeError& a, const NodeError& b) { return a.center < b.center; });
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
        const auto error =
            std::lower_bound(errors_.begin(), errors_.end(), child.center,
                             [](const NodeError& node, const Point& c) { return node.center < c; });
        if (error != errors_.end() && error->center == child.center)
          task.least_error = std::max(task.least_error, error->error);
        const auto entry =
            std::lower_bound(children_.begin(), children_.end(), child,
                             [](const TetrahedronRecord& r, const TetrahedronId& id) { return r.id < id; });
        if (entry == children_.end() || !(entry->id == child)) continue;
        task.parts.push_back({static_cast<std::uint32_t>(place), static_cast<std::uint32_t>(end),
                              entry->triangles, 0, entry->record});
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
  template <typename Make>
  void run_tasks(const std::string& name, std::vector<PlannedTask> tasks, const Make& make,
                 std::optional<std::uint32_t> simplified) {
    nodes::Level level;
    level.name = name;
    level.tasks = std::move(tasks);
    level.task_name = "a diamond";
    level.task_bytes = task_bytes;
    level.make = [&](std::size_t index) { return make(index).to_bytes(); };
    level.work = [&](std::span<const std::byte> bytes) {
      return build_node(workspace_, settings_, NodeTask::from_bytes(bytes)).to_bytes();
    };
    level.take = [&](std::span<const std::byte> bytes) { return take(NodeResult::from_bytes(bytes)); };
    level.simplified = simplified;
    driver_.run(std::move(level));
  }

  std::vector<facts::FinishedNode> take(const NodeResult& result) {
    const container::NodeRow& row = result.node.row;
    errors_by_level_[static_cast<int>(row.level)].push_back(
        {{row.center[0], row.center[1], row.center[2]}, row.error});
    made_.insert(made_.end(), result.tetrahedra.begin(), result.tetrahedra.end());
    return {result.node};
  }

  const run::Workspace& workspace_;
  nodes::LevelDriver driver_;
  const NodeSettings& settings_;
  const Partition& partition_;
  facts::Catalog& catalog_;
  const std::vector<TetrahedronRecord>& leaves_;
  std::map<int, std::vector<Point>> splits_by_level_;
  std::vector<TetrahedronRecord> made_;      // by the level at hand
  std::vector<TetrahedronRecord> children_;  // of the level at hand, by id
  std::vector<NodeError> errors_;            // of the nodes below the level at hand, by centre
  std::map<int, std::vector<NodeError>> errors_by_level_;
};

}  // namespace

facts::FinishedNodes build_levels(const run::Workspace& workspace, const NodeSettings& settings,
                                  const Partition& partition, facts::Catalog& catalog) {
  return LevelBuilder(workspace, settings, partition, catalog).run();
}

}  // namespace colossus::pipeline::diamonds
