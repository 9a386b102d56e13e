#include "pipeline/blocks/scheme.hpp"

#include <array>
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

constexpr facts::TypedOption<std::int64_t> kBlockSize{
    "block_size", "cubes along a block",
    "Cubes along each axis of the blocks in which levels were simplified", kDefaultBlockSize,
    facts::Stored::kAlways};
constexpr facts::TypedOption<std::int64_t> kLevels{
    "levels", "the deepest level, instead of the one that fits", "Number of the deepest level"};
constexpr facts::TypedOption<double> kColorWeight{
    "color_weight", "mean edge lengths that a full change of colour counts when simplifying",
    "Mean edge lengths that a full change of colour counts when simplifying", 0.0};
constexpr facts::TypedOption<bool> kShiftedBlocks{"shifted_blocks", nullptr, "", true, facts::Stored::kNever};
constexpr std::array<facts::SchemeOption, 4> kOptions{kBlockSize, kLevels, kColorWeight, kShiftedBlocks};

// The deepest level.
int deepest_level(const facts::BuildOptions& options, const facts::Catalog& catalog,
                  const ingest::Occupancy& occupancy) {
  const auto triangles = static_cast<double>(catalog.counts.triangles);
  int level = 0;
  while (level < geometry::kRootBits &&
         triangles > static_cast<double>(options.leaf_triangles) * occupancy.cubes_at(level))
    ++level;
  return static_cast<int>(options_of(options).levels.value_or(level));
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
  const double most = most_in_block(occupancy, level, static_cast<int>(options_of(options).block_size));
  nodes::NodeNeeds needs;
  const bool weighs_colors = catalog.has_colors && options_of(options).color_weight > 0.0;
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
  const int most_levels = geometry::kRootBits - codec::coded::kMaxPositionBits;
  const Options own = options_of(options);
  if (own.levels && (*own.levels < 0 || *own.levels > most_levels))
    core::fail(Status::kUsage, "--levels {} is out of range; choose 0 to {}", *own.levels, most_levels);
  if (own.block_size < hierarchy::kLeastBlockSize || own.block_size > hierarchy::kGreatestBlockSize ||
      own.block_size % 4 != 0)
    core::fail(Status::kUsage, "--block-size {} is out of range; choose a multiple of 4, {} to {}",
               own.block_size, hierarchy::kLeastBlockSize, hierarchy::kGreatestBlockSize);
  if (!std::isfinite(own.color_weight) || own.color_weight < 0.0)
    core::fail(Status::kUsage, "--color-weight {} is out of range; choose 0 or a positive number",
               own.color_weight);
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
  Partition leaves = partition(workspace, catalog, grid, std::move(groups));
  buckets::log_counts(workspace.ranks, catalog);
  const std::uint64_t peak = run::greatest_peak_memory(workspace.ranks);
  core::log("partition: {} edges too long for their cubes split, peak memory {} MB",
            catalog.counts.split_edges, peak >> 20);

  NodeSettings settings;
  settings.lattice = catalog.lattice;
  settings.grid = grid;
  settings.codec = &codec::codec_named(workspace.options.codec);
  settings.has_colors = catalog.has_colors;
  const Options options = options_of(workspace.options);
  settings.color_weight = options.color_weight;
  settings.rounding_error = rounding_error;
  settings.block_size = static_cast<int>(options.block_size);
  settings.has_shifted_blocks = options.has_shifted_blocks;
  workspace.ranks.attempt([&] {
    if (workspace.ranks.is_root())
      require_tolerance(workspace.options, settings.input_error(leaves.displacement));
  });
  facts::FinishedNodes finished = build_levels(workspace, settings, std::move(leaves), catalog);
  facts::SchemeValues chosen = workspace.options.of_scheme;
  chosen[kLevels.name] = std::int64_t{grid.levels};
  finished.options = stored_values(kOptions, chosen);
  finished.option_meanings = facts::meanings_of(kOptions);
  return finished;
}

}  // namespace

Options options_of(const facts::BuildOptions& options) {
  const facts::SchemeValues& values = options.of_scheme;
  return {value_of(kLevels, values), *value_of(kBlockSize, values), *value_of(kColorWeight, values),
          *value_of(kShiftedBlocks, values)};
}

constinit const nodes::Scheme kScheme{hierarchy::kBlocks,
                                      "uncut triangles, continuous morphing, painted models",
                                      "on average per cube of the deepest level",
                                      "along a cube of the deepest level",
                                      kOptions,
                                      &check,
                                      &estimate,
                                      &build};

}  // namespace colossus::pipeline::blocks
