#include "build/diamonds/diamonds.hpp"

#include <algorithm>
#include <cmath>

#include "build/diamonds/levels.hpp"
#include "build/diamonds/partition.hpp"
#include "build/memory.hpp"
#include "core/log.hpp"

namespace colossus::build {
namespace {

// The bits that keep every leaf's quantisation within the tolerance. Rounding changes the weights by at most
// three units in all (one each for three corners that must not become 0), so it moves a vertex by at most
// three times the longest edge over 2^bits.
constexpr double kWeightUnits = 3.0;

int bits_for_tolerance(double tolerance, const Partition& partition, const geometry::Lattice& lattice) {
  double longest = 0.0;
  for (const TetrahedronRecord& leaf : partition.leaves) {
    const hierarchy::Diamond diamond = hierarchy::Diamond::at(leaf.id.center);
    longest =
        std::max(longest, std::sqrt(static_cast<double>(squared_distance(diamond.ends[0], diamond.ends[1]))));
  }
  for (int bits = codec::kMinPositionBits; bits <= codec::kMaxPositionBits; ++bits)
    if (kWeightUnits * longest * lattice.step / static_cast<double>(1 << bits) <= tolerance) return bits;
  core::warn("--tolerance {} is finer than {} bits in the largest leaf give ({}); use smaller leaves",
             tolerance, codec::kMaxPositionBits,
             kWeightUnits * longest * lattice.step / static_cast<double>(1 << codec::kMaxPositionBits));
  return codec::kMaxPositionBits;
}

void log_partition(const cluster::Communicator& ranks, const Catalog& catalog, const Partition& partition) {
  const InputCounts& c = catalog.counts;
  std::uint64_t triangles = 0;
  for (const TetrahedronRecord& leaf : partition.leaves) triangles += leaf.triangles;
  core::log(
      "partition: {} degenerate and {} duplicate triangles dropped; {} border and {} non-manifold edges",
      c.degenerate, c.duplicate, c.border_edges, c.nonmanifold_edges);
  const std::uint64_t peak = greatest_peak_memory(ranks);
  core::log("partition: {} triangles in {} leaf tetrahedra, peak memory {} MB", triangles,
            partition.leaves.size(), peak >> 20);
}

}  // namespace

void check_diamonds(const BuildOptions& options) {
  if (options.position_bits < codec::kMinPositionBits || options.position_bits > codec::kMaxPositionBits)
    core::fail(core::Status::kUsage, "--position-bits {} is out of range; choose {} to {}",
               options.position_bits, codec::kMinPositionBits, codec::kMaxPositionBits);
  if (options.levels) core::fail(core::Status::kUsage, "--levels is an option of --scheme blocks only");
  if (options.block_size)
    core::fail(core::Status::kUsage, "--block-size is an option of --scheme blocks only");
  if (options.color_weight != 0.0)
    core::fail(core::Status::kUsage, "--color-weight is an option of --scheme blocks only");
}

Hierarchy build_diamonds(const Workspace& workspace, Catalog& catalog) {
  const cluster::Communicator& ranks = workspace.ranks;
  const Partition leaves = partition(workspace, catalog);
  log_partition(ranks, catalog, leaves);
  NodeSettings settings;
  settings.lattice = catalog.lattice;
  settings.quantize.position_bits = workspace.options.position_bits;
  if (workspace.options.tolerance) {
    if (ranks.is_root())
      settings.quantize.position_bits =
          bits_for_tolerance(*workspace.options.tolerance, leaves, catalog.lattice);
    broadcast_value(ranks, settings.quantize.position_bits);
  }
  settings.quantize.normals = true;
  settings.codec = &codec::codec_named(workspace.options.codec);
  settings.quantize.colors = catalog.has_colors;
  settings.leaf_triangles = workspace.options.leaf_triangles;
  settings.floor_triangles = floor_triangles(workspace.options);
  settings.input_error = catalog.lattice.input_error();
  Hierarchy hierarchy = build_levels(workspace, settings, leaves);
  hierarchy.lattice = {catalog.lattice.origin, catalog.lattice.step, geometry::kRootBits};
  hierarchy.position_bits = settings.quantize.position_bits;
  return hierarchy;
}

}  // namespace colossus::build
