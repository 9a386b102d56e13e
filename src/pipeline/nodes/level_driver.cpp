#include "pipeline/nodes/level_driver.hpp"

#include <algorithm>
#include <utility>

#include "core/log.hpp"
#include "pipeline/nodes/finest_level.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::nodes {

void LevelDriver::run(Level level) {
  std::stable_sort(level.tasks.begin(), level.tasks.end(),
                   [](const PlannedTask& a, const PlannedTask& b) { return a.triangles > b.triangles; });
  std::uint64_t nodes = 0, triangles = 0;
  run_phase(
      workspace_, level.name, level.tasks.size(),
      [&](std::size_t i) {
        const PlannedTask& task = level.tasks[i];
        require_memory(workspace_, level.task_bytes(task.triangles),
                       fmt::format("{} of {} triangles in {}", level.task_name, task.triangles, level.name));
        return level.make(task.index);
      },
      level.work,
      [&](std::size_t, const core::Bytes& bytes) {
        for (const facts::FinishedNode& node : level.take(bytes)) {
          finished_.add(node);
          ++nodes;
          triangles += node.row.triangles;
        }
      });
  const std::uint64_t peak = run::greatest_peak_memory(workspace_.ranks);
  core::log("{}: {}, {} triangles, peak memory {} MB", level.name,
            level.nodes_text ? level.nodes_text(nodes) : fmt::format("{} nodes", nodes), triangles,
            peak >> 20);
  if (level.simplified && workspace_.ranks.is_root()) warn_of_missed_target(finished_, *level.simplified);
}

void LevelDriver::finish_finest(const facts::Catalog& catalog, const std::function<void()>& check) {
  workspace_.ranks.attempt([&] {
    if (!workspace_.ranks.is_root()) return;
    if (check) check();
    double greatest = 0.0;
    for (const facts::StoredNode& node : finished_.nodes) greatest = std::max(greatest, node.row.error);
    require_tolerance(workspace_.options, greatest);
    finished_.sort();
    refuse_lost_surface(catalog, finished_);
  });
}

facts::FinishedNodes LevelDriver::take() {
  finished_.sort();
  return std::move(finished_);
}

}  // namespace colossus::pipeline::nodes
