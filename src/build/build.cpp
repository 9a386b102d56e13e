#include "build/build.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "build/assemble.hpp"
#include "build/levels.hpp"
#include "build/partition.hpp"
#include "build/survey.hpp"
#include "core/log.hpp"
#include "scratch/directory.hpp"

namespace colossus::build {
namespace {

void check_options(const cluster::Communicator& ranks, const BuildOptions& options) {
  ranks.attempt([&] {
    if (options.leaf_triangles < 16)
      core::fail(core::Status::kUsage, "--leaf-triangles {} is too small; the least is 16",
                 options.leaf_triangles);
    if (options.position_bits < codec::kMinPositionBits || options.position_bits > codec::kMaxPositionBits)
      core::fail(core::Status::kUsage, "--position-bits {} is out of range; choose {} to {}",
                 options.position_bits, codec::kMinPositionBits, codec::kMaxPositionBits);
    if (options.tolerance && !(*options.tolerance > 0.0))
      core::fail(core::Status::kUsage, "--tolerance {} is not a positive length", *options.tolerance);
  });
}

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

void log_survey(const Catalog& catalog) {
  const InputCounts& c = catalog.counts;
  core::log(
      "survey: {} vertices, {} triangles ({} polygons as fans, {} faces with fewer than 3 corners skipped)",
      c.vertices, c.triangles, c.polygons, c.small_faces);
  core::log("survey: bounds {} {} {} to {} {} {}", catalog.bounds.low[0], catalog.bounds.low[1],
            catalog.bounds.low[2], catalog.bounds.high[0], catalog.bounds.high[1], catalog.bounds.high[2]);
}

void log_partition(const Catalog& catalog, const Partition& partition) {
  const InputCounts& c = catalog.counts;
  std::uint64_t triangles = 0;
  for (const TetrahedronRecord& leaf : partition.leaves) triangles += leaf.triangles;
  core::log(
      "partition: {} degenerate and {} duplicate triangles dropped; {} border and {} non-manifold edges",
      c.degenerate, c.duplicate, c.border_edges, c.nonmanifold_edges);
  core::log("partition: {} triangles in {} leaf tetrahedra", triangles, partition.leaves.size());
}

BuildReport run_phases(const Workspace& workspace) {
  const cluster::Communicator& ranks = workspace.ranks;
  Catalog catalog = survey(workspace);
  log_survey(catalog);
  place_on_lattice(workspace, catalog);
  core::log("lattice: step {} (input vertices moved by at most {}), origin {} {} {}", catalog.lattice.step,
            catalog.lattice.input_error(), catalog.lattice.origin[0], catalog.lattice.origin[1],
            catalog.lattice.origin[2]);
  if (catalog.counts.merged_vertices > 0)
    core::log("lattice: {} vertices lie where others do and are merged; attributes averaged at {} positions",
              catalog.counts.merged_vertices, catalog.counts.attribute_seams);
  const Partition leaves = partition(workspace, catalog);
  log_partition(catalog, leaves);

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
  settings.quantize.colors = catalog.has_colors;
  settings.leaf_triangles = workspace.options.leaf_triangles;
  settings.floor_triangles = floor_triangles(workspace.options);
  settings.input_error = catalog.lattice.input_error();
  const Hierarchy hierarchy = build_levels(workspace, settings, leaves);

  BuildReport report;
  report.input_triangles = catalog.counts.triangles;
  ranks.attempt([&] {
    if (ranks.is_root()) report.output_bytes = assemble(workspace, catalog, settings, hierarchy);
  });
  report.nodes = hierarchy.nodes.size();
  broadcast_value(ranks, report);
  return report;
}

}  // namespace

BuildReport build(const cluster::Communicator& ranks, const BuildOptions& options) {
  check_options(ranks, options);
  std::filesystem::path scratch = options.scratch;
  if (scratch.empty()) scratch = options.output.string() + ".scratch";
  ranks.attempt([&] {
    const std::filesystem::path folder =
        options.output.has_parent_path() ? options.output.parent_path() : ".";
    if (ranks.is_root() && !std::filesystem::is_directory(folder))
      core::fail(core::Status::kCannotCreate, "{}: the folder {} does not exist", options.output.string(),
                 folder.string());
  });
  std::optional<scratch::ScratchDirectory> directory;
  ranks.attempt([&] {
    if (ranks.is_root()) directory.emplace(scratch::ScratchDirectory::create(scratch));
  });
  ranks.attempt([&] {
    if (!ranks.is_root()) directory.emplace(scratch::ScratchDirectory::open(scratch));
  });
  BuildReport report;
  {
    std::optional<scratch::SpoolWriter> writer;
    ranks.attempt([&] { writer.emplace(scratch, static_cast<std::uint32_t>(ranks.rank())); });
    scratch::SpoolReader reader(scratch);
    report = run_phases({ranks, options, scratch, *writer, reader});
  }
  ranks.barrier();
  ranks.attempt([&] {
    if (ranks.is_root()) directory->remove();
  });
  return report;
}

}  // namespace colossus::build
