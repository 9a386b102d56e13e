#include "pipeline/blocks/scheme.hpp"

#include <cmath>

#include "core/log.hpp"
#include "pipeline/blocks/fullest_block.hpp"
#include "pipeline/blocks/levels.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/ingest/extent.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::blocks {
namespace {

// The deepest level.
int deepest_level(const facts::BuildOptions& options, const facts::Catalog& catalog,
                  const ingest::Occupancy& occupancy) {
  const auto triangles = static_cast<double>(catalog.counts.triangles);
  int level = 0;
  while (level < geometry::kRootBits &&
         triangles > static_cast<double>(options.leaf_triangles) * occupancy.cubes_at(level))
    ++level;
  return options.levels.value_or(level);
}

// Of builds of statues of 0.1 to 6 million triangles, see src/README.md.
constexpr double kMapBytes = 0.2;  // of the output, per stored triangle: the map to the parents
// Of scratch, while levels are made.
constexpr double kMeshBytes = 48.0;    // of meshes, per triangle of the input
constexpr double kSampleBytes = 14e3;  // of the samples, per cube of the deepest level

nodes::NodeNeeds estimate(const facts::BuildOptions& options, const facts::Catalog& catalog,
                          const ingest::Occupancy& occupancy) {
  const auto triangles = static_cast<double>(catalog.counts.triangles);
  const auto vertices = static_cast<double>(catalog.counts.vertices);
  const int level = deepest_level(options, catalog, occupancy);
  const double most = most_in_block(occupancy, level, options.block_size.value_or(kDefaultBlockSize));
  nodes::NodeNeeds needs;
  const bool weighs_colors = catalog.has_colors && options.color_weight > 0.0;
  needs.task_bytes =
      static_cast<double>(bytes_per_triangle(weighs_colors)) * most / std::max(vertices, 1.0) * triangles;
  needs.stored_triangles = 4.0 / 3.0;  // each level has a quarter of the next
  needs.node_triangles = triangles / occupancy.cubes_at(level);
  needs.more_bytes = kMapBytes;
  needs.scratch_bytes = kMeshBytes + kSampleBytes / static_cast<double>(options.leaf_triangles);
  return needs;
}

void check(const facts::BuildOptions& options) {
  using core::Status;
  if (options.position_bits < codec::coded::kMinPositionBits ||
      options.position_bits > codec::coded::kMaxPositionBits)
    core::fail(Status::kUsage, "--position-bits {} is out of range; choose {} to {}", options.position_bits,
               codec::coded::kMinPositionBits, codec::coded::kMaxPositionBits);
  const int most_levels = geometry::kRootBits - codec::coded::kMaxPositionBits;
  if (options.levels && (*options.levels < 0 || *options.levels > most_levels))
    core::fail(Status::kUsage, "--levels {} is out of range; choose 0 to {}", *options.levels, most_levels);
  if (options.block_size &&
      (*options.block_size < hierarchy::kLeastBlockSize ||
       *options.block_size > hierarchy::kGreatestBlockSize || *options.block_size % 4 != 0))
    core::fail(Status::kUsage, "--block-size {} is out of range; choose a multiple of 4, {} to {}",
               *options.block_size, hierarchy::kLeastBlockSize, hierarchy::kGreatestBlockSize);
  if (!std::isfinite(options.color_weight) || options.color_weight < 0.0)
    core::fail(Status::kUsage, "--color-weight {} is out of range; choose 0 or a positive number",
               options.color_weight);
}

facts::FinishedNodes build(const run::Workspace& workspace, facts::Catalog& catalog,
                           std::vector<ingest::TriangleGroup>&& groups) {
  const Grid grid = choose_grid(workspace, catalog, groups);
  core::log("grid: {} levels of cubes, positions rounded to {}", grid.levels,
            catalog.lattice.step * grid.spacing());
  const double rounding_error =
      catalog.lattice.input_error() + std::sqrt(3.0) / 2.0 * grid.spacing() * catalog.lattice.step;
  workspace.ranks.attempt([&] {
    if (workspace.ranks.is_root())
      ingest::refuse_far_corner(workspace.options, catalog, 2.0 * rounding_error);
  });
  Partition leaves = partition(workspace, catalog, grid, groups);
  groups = {};
  buckets::log_counts(workspace.ranks, catalog);
  const std::uint64_t peak = run::greatest_peak_memory(workspace.ranks);
  core::log("partition: {} edges too long for their cubes split, peak memory {} MB",
            catalog.counts.split_edges, peak >> 20);

  NodeSettings settings;
  settings.lattice = catalog.lattice;
  settings.grid = grid;
  settings.codec = &codec::codec_named(workspace.options.codec);
  settings.has_colors = catalog.has_colors;
  settings.color_weight = workspace.options.color_weight;
  settings.rounding_error = rounding_error;
  settings.block_size = workspace.options.block_size.value_or(kDefaultBlockSize);
  settings.has_shifted_blocks = workspace.options.has_shifted_blocks;
  workspace.ranks.attempt([&] {
    if (workspace.ranks.is_root())
      require_tolerance(workspace.options, settings.input_error(leaves.displacement));
  });
  facts::FinishedNodes finished = build_levels(workspace, settings, std::move(leaves), catalog);
  facts::BuildOptions chosen = workspace.options;
  chosen.block_size = settings.block_size;
  chosen.levels = grid.levels;
  finished.options = stored_options(chosen, hierarchy::kBlocks);
  return finished;
}

}  // namespace

const nodes::Scheme kScheme{hierarchy::kBlocks, "uncut triangles, continuous morphing, painted models",
                            &check, &estimate, &build};

}  // namespace colossus::pipeline::blocks
