#include "pipeline/blocks/levels.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/nodes/level_driver.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::blocks {
namespace {

using core::Bytes;
using hierarchy::BlockId;
using hierarchy::CubeId;

class LevelBuilder {
 public:
  LevelBuilder(const run::Workspace& workspace, const NodeSettings& settings, Partition&& partition,
               const facts::Catalog& catalog)
      : workspace_(workspace), driver_(workspace), settings_(settings), catalog_(catalog) {
    driver_.finished().lattice = {settings.lattice.origin, settings.lattice.step * settings.grid.spacing(),
                                  settings.grid.root_bits()};
    driver_.finished().position_bits = settings.grid.position_bits;
    for (const CubeRecord& cube : partition.cubes)
      cubes_.push_back({cube, settings.input_error(cube.displacement)});
    partition.cubes = {};
    sigma_ = in_cubes(partition.longest_edge, settings.grid.levels);
  }

  facts::FinishedNodes run() {
    for (int level = settings_.grid.levels; level >= 0; --level) {
      run_level(level);
      if (level == settings_.grid.levels) driver_.finish_finest(catalog_);
    }
    facts::FinishedNodes finished = driver_.take();
    double sigma = sigma_;
    broadcast_value(workspace_.ranks, sigma);
    finished.parameters = {{"block_size", static_cast<double>(settings_.block_size)}, {"sigma0", sigma}};
    return finished;
  }

 private:
  // Exact: a quotient by a power of two.
  static double in_cubes(std::int64_t length, int level) {
    return std::ldexp(static_cast<double>(length), level - geometry::kRootBits);
  }

  struct PlannedBlock {
    BlockId block;
    std::vector<std::uint32_t> cubes;  // numbers in cubes_
    std::uint64_t triangles = 0;
  };

  std::vector<PlannedBlock> plan_blocks() const {
    std::map<BlockId, PlannedBlock> by_block;
    for (std::uint32_t i = 0; i < cubes_.size(); ++i) {
      const BlockId block = settings_.block_of(cubes_[i].record.id);
      PlannedBlock& task = by_block[block];
      task.block = block;
      task.cubes.push_back(i);
      task.triangles += cubes_[i].record.triangles;
    }
    std::vector<PlannedBlock> blocks;
    blocks.reserve(by_block.size());
    for (auto& [block, planned] : by_block) blocks.push_back(std::move(planned));
    return blocks;
  }

  NodeTask make_task(const PlannedBlock& planned) const {
    NodeTask task;
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
  std::vector<CubeId> around(const NodeTask& task) const {
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

  void run_level(int number) {
    const std::vector<PlannedBlock> blocks = plan_blocks();
    std::vector<BlockCube> parents;
    nodes::Level level;
    level.name = fmt::format("level {}", number);
    for (std::size_t i = 0; i < blocks.size(); ++i) level.tasks.push_back({i, blocks[i].triangles});
    level.task_name = "a block";
    level.task_bytes = [&](std::uint64_t triangles) { return task_bytes(settings_, triangles); };
    level.make = [&](std::size_t i) { return make_task(blocks[i]).to_bytes(); };
    level.work = [&](std::span<const std::byte> bytes) {
      return build_block(workspace_, settings_, NodeTask::from_bytes(bytes)).to_bytes();
    };
    level.take = [&](std::span<const std::byte> bytes) {
      NodeResult result = NodeResult::from_bytes(bytes);
      parents.insert(parents.end(), result.parents.begin(), result.parents.end());
      if (number > 0) driver_.finished().add(static_cast<std::uint32_t>(number - 1), result.statistics);
      sigma_ = std::max(sigma_, in_cubes(result.farthest_parent, number + 1));
      return std::move(result.nodes);
    };
    level.nodes_text = [&](std::uint64_t cubes) {
      return fmt::format("{} cubes in {} blocks", cubes, blocks.size());
    };
    // Which makes the one above it.
    if (number > 0) level.simplified = static_cast<std::uint32_t>(number - 1);
    driver_.run(std::move(level));
    release_phases_up_to(workspace_, last_phase(workspace_) - 1);
    cubes_ = std::move(parents);
    std::sort(cubes_.begin(), cubes_.end(),
              [](const BlockCube& a, const BlockCube& b) { return a.record.id < b.record.id; });
  }

  const run::Workspace& workspace_;
  nodes::LevelDriver driver_;
  const NodeSettings& settings_;
  const facts::Catalog& catalog_;
  std::vector<BlockCube> cubes_;  // of the level at hand; on rank 0
  double sigma_ = 0.0;
};

}  // namespace

facts::FinishedNodes build_levels(const run::Workspace& workspace, const NodeSettings& settings,
                                  Partition&& partition, const facts::Catalog& catalog) {
  return LevelBuilder(workspace, settings, std::move(partition), catalog).run();
}

}  // namespace colossus::pipeline::blocks
