#include "build/blocks/levels.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "build/phase.hpp"
#include "core/log.hpp"

namespace colossus::build {
namespace {

using core::Bytes;
using hierarchy::BlockId;
using hierarchy::CubeId;

class BlockLevelBuilder {
 public:
  BlockLevelBuilder(const Workspace& workspace, const BlockSettings& settings, int block_size,
                    const CubePartition& partition)
      : workspace_(workspace), settings_(settings), block_size_(block_size) {
    for (const CubeRecord& cube : partition.cubes)
      cubes_.push_back({cube, settings.input_error(cube.displacement)});
    sigma_ = in_cubes(partition.longest_edge, settings.grid.levels);
  }

  Hierarchy run() {
    for (int level = settings_.grid.levels; level >= 0; --level) run_level(level);
    hierarchy_.sort();
    double sigma = sigma_;
    broadcast_value(workspace_.ranks, sigma);
    hierarchy_.parameters = {{"block_size", static_cast<double>(block_size_)}, {"sigma0", sigma}};
    return std::move(hierarchy_);
  }

 private:
  // Exact: a quotient by a power of two.
  static double in_cubes(std::int64_t length, int level) {
    return std::ldexp(static_cast<double>(length), level - geometry::kRootBits);
  }

  std::vector<BlockTask> tasks_of_level() const {
    std::map<BlockId, BlockTask> by_block;
    std::unordered_map<CubeId, const CubeRecord*, hierarchy::CubeIdHash> by_id;
    for (const BlockCube& cube : cubes_) {
      const BlockId block = hierarchy::block_of(cube.record.id, block_size_);
      by_block[block].cubes.push_back(cube);
      by_id.emplace(cube.record.id, &cube.record);
    }
    std::vector<BlockTask> tasks;
    for (auto& [block, task] : by_block) {
      task.block = block;
      for_each_around(task.cubes, block, by_id,
                      [&](const CubeRecord& cube) { task.rims.push_back(cube.rim); });
      tasks.push_back(std::move(task));
    }
    return tasks;
  }

  // The cubes of other blocks that touch one of these, in order.
  template <typename ById, typename Visit>
  void for_each_around(const std::vector<BlockCube>& cubes, const BlockId& block, const ById& by_id,
                       const Visit& visit) const {
    std::vector<CubeId> around;
    for (const BlockCube& cube : cubes)
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const CubeId& id = cube.record.id;
            const CubeId other{id.level, id.x + dx, id.y + dy, id.z + dz};
            if (other.is_inside_root() && hierarchy::block_of(other, block_size_) != block)
              around.push_back(other);
          }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    for (const CubeId& id : around)
      if (const auto found = by_id.find(id); found != by_id.end()) visit(*found->second);
  }

  static std::uint64_t cost_of(const BlockTask& task) {
    std::uint64_t triangles = 0;
    for (const BlockCube& cube : task.cubes) triangles += cube.record.triangles;
    return triangles;
  }

  void run_level(int level) {
    std::vector<BlockTask> tasks;
    if (workspace_.ranks.is_root()) tasks = tasks_of_level();
    // The largest first, so that none of them starts last.
    std::stable_sort(tasks.begin(), tasks.end(),
                     [](const BlockTask& a, const BlockTask& b) { return cost_of(a) > cost_of(b); });
    cubes_.clear();
    std::uint64_t triangles = 0, nodes = 0;
    NodeStatistics made;
    run_phase(
        workspace_, fmt::format("level {}", level), tasks.size(),
        [&](std::size_t i) { return tasks[i].to_bytes(); },
        [&](std::span<const std::byte> bytes) {
          return build_block(workspace_, settings_, BlockTask::from_bytes(bytes)).to_bytes();
        },
        [&](std::size_t, const Bytes& bytes) {
          BlockResult result = BlockResult::from_bytes(bytes);
          for (const FinishedNode& node : result.nodes) {
            hierarchy_.add(node);
            ++nodes;
            triangles += node.row.triangles;
          }
          cubes_.insert(cubes_.end(), result.parents.begin(), result.parents.end());
          if (level > 0) hierarchy_.add(static_cast<std::uint32_t>(level - 1), result.statistics);
          sigma_ = std::max(sigma_, in_cubes(result.farthest_parent, level + 1));
        });
    std::sort(cubes_.begin(), cubes_.end(),
              [](const BlockCube& a, const BlockCube& b) { return a.record.id < b.record.id; });
    core::log("level {}: {} cubes in {} blocks, {} triangles, peak memory {} MB", level, nodes, tasks.size(),
              triangles, core::peak_memory_bytes() >> 20);
  }

  const Workspace& workspace_;
  const BlockSettings& settings_;
  int block_size_;
  std::vector<BlockCube> cubes_;  // of the level at hand; on rank 0
  double sigma_ = 0.0;
  Hierarchy hierarchy_;
};

}  // namespace

Hierarchy build_block_levels(const Workspace& workspace, const BlockSettings& settings, int block_size,
                             const CubePartition& partition) {
  return BlockLevelBuilder(workspace, settings, block_size, partition).run();
}

}  // namespace colossus::build
