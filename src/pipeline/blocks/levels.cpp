#include "pipeline/blocks/levels.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/log.hpp"
#include "pipeline/nodes/finest_level.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::blocks {
namespace {

using core::Bytes;
using hierarchy::BlockId;
using hierarchy::CubeId;

class BlockLevelBuilder {
 public:
  BlockLevelBuilder(const run::Workspace& workspace, const BlockSettings& settings, CubePartition&& partition,
                    const facts::Catalog& catalog)
      : workspace_(workspace), settings_(settings), catalog_(catalog) {
    hierarchy_.lattice = {settings.lattice.origin, settings.lattice.step * settings.grid.spacing(),
                          settings.grid.root_bits()};
    hierarchy_.position_bits = settings.grid.position_bits;
    for (const CubeRecord& cube : partition.cubes)
      cubes_.push_back({cube, settings.input_error(cube.displacement)});
    partition.cubes = {};
    sigma_ = in_cubes(partition.longest_edge, settings.grid.levels);
  }

  facts::Hierarchy run() {
    for (int level = settings_.grid.levels; level >= 0; --level) {
      run_level(level);
      if (level == settings_.grid.levels)
        workspace_.ranks.attempt([&] {
          if (!workspace_.ranks.is_root()) return;
          hierarchy_.sort();
          nodes::refuse_lost_surface(catalog_, hierarchy_);
        });
      // Which made the one above it.
      if (workspace_.ranks.is_root() && level > 0)
        warn_of_missed_target(hierarchy_, static_cast<std::uint32_t>(level - 1));
    }
    hierarchy_.sort();
    double sigma = sigma_;
    broadcast_value(workspace_.ranks, sigma);
    hierarchy_.parameters = {{"block_size", static_cast<double>(settings_.block_size)}, {"sigma0", sigma}};
    return std::move(hierarchy_);
  }

 private:
  // Exact: a quotient by a power of two.
  static double in_cubes(std::int64_t length, int level) {
    return std::ldexp(static_cast<double>(length), level - geometry::kRootBits);
  }

  // Made into a BlockTask when it is about to be sent.
  struct PlannedTask {
    BlockId block;
    std::vector<std::uint32_t> cubes;  // numbers in cubes_
    std::uint64_t triangles = 0;
  };

  std::vector<PlannedTask> plan_tasks() const {
    std::map<BlockId, PlannedTask> by_block;
    for (std::uint32_t i = 0; i < cubes_.size(); ++i) {
      const BlockId block = settings_.block_of(cubes_[i].record.id);
      PlannedTask& task = by_block[block];
      task.block = block;
      task.cubes.push_back(i);
      task.triangles += cubes_[i].record.triangles;
    }
    std::vector<PlannedTask> tasks;
    for (auto& [block, task] : by_block) tasks.push_back(std::move(task));
    // The largest first, so that none of them starts last.
    std::stable_sort(tasks.begin(), tasks.end(),
                     [](const PlannedTask& a, const PlannedTask& b) { return a.triangles > b.triangles; });
    return tasks;
  }

  BlockTask make_task(const PlannedTask& planned) const {
    BlockTask task;
    task.block = planned.block;
    for (const auto i : planned.cubes) task.cubes.push_back(cubes_[i]);
    for (const CubeId& id : around(task)) {
      const auto found =
          std::lower_bound(cubes_.begin(), cubes_.end(), id,
                           [](const BlockCube& cube, const CubeId& at) { return cube.record.id < at; });
      if (found != cubes_.end() && found->record.id == id) task.rims.push_back(found->record.rim);
    }
    return task;
  }

  // The places of cubes of other blocks that touch one of the task's, in order.
  std::vector<CubeId> around(const BlockTask& task) const {
    std::vector<CubeId> around;
    for (const BlockCube& cube : task.cubes)
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const CubeId& id = cube.record.id;
            const CubeId other{id.level, id.x + dx, id.y + dy, id.z + dz};
            if (other.is_inside_root() && settings_.block_of(other) != task.block) around.push_back(other);
          }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
  }

  void run_level(int level) {
    const std::string name = fmt::format("level {}", level);
    const std::vector<PlannedTask> tasks = plan_tasks();
    std::vector<BlockCube> parents;
    std::uint64_t triangles = 0, nodes = 0;
    run_phase(
        workspace_, name, tasks.size(),
        [&](std::size_t i) {
          require_memory(workspace_, block_bytes(settings_, tasks[i].triangles),
                         fmt::format("a block of {} triangles in {}", tasks[i].triangles, name));
          return make_task(tasks[i]).to_bytes();
        },
        [&](std::span<const std::byte> bytes) {
          return build_block(workspace_, settings_, BlockTask::from_bytes(bytes)).to_bytes();
        },
        [&](std::size_t, const Bytes& bytes) {
          BlockResult result = BlockResult::from_bytes(bytes);
          for (const facts::FinishedNode& node : result.nodes) {
            hierarchy_.add(node);
            ++nodes;
            triangles += node.row.triangles;
          }
          parents.insert(parents.end(), result.parents.begin(), result.parents.end());
          if (level > 0) hierarchy_.add(static_cast<std::uint32_t>(level - 1), result.statistics);
          sigma_ = std::max(sigma_, in_cubes(result.farthest_parent, level + 1));
        });
    release_phases_up_to(workspace_, last_phase(workspace_) - 1);
    cubes_ = std::move(parents);
    std::sort(cubes_.begin(), cubes_.end(),
              [](const BlockCube& a, const BlockCube& b) { return a.record.id < b.record.id; });
    const std::uint64_t peak = run::greatest_peak_memory(workspace_.ranks);
    core::log("{}: {} cubes in {} blocks, {} triangles, peak memory {} MB", name, nodes, tasks.size(),
              triangles, peak >> 20);
  }

  const run::Workspace& workspace_;
  const BlockSettings& settings_;
  const facts::Catalog& catalog_;
  std::vector<BlockCube> cubes_;  // of the level at hand; on rank 0
  double sigma_ = 0.0;
  facts::Hierarchy hierarchy_;
};

}  // namespace

facts::Hierarchy build_block_levels(const run::Workspace& workspace, const BlockSettings& settings,
                                    CubePartition&& partition, const facts::Catalog& catalog) {
  return BlockLevelBuilder(workspace, settings, std::move(partition), catalog).run();
}

}  // namespace colossus::pipeline::blocks
