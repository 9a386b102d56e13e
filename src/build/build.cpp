#include "build/build.hpp"

#include <optional>

#include "build/assemble.hpp"
#include "build/memory.hpp"
#include "build/scheme.hpp"
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
    if (options.tolerance && !(*options.tolerance > 0.0))
      core::fail(core::Status::kUsage, "--tolerance {} is not a positive length", *options.tolerance);
    scheme_named(options.scheme).check(options);
  });
}

void log_survey(const Catalog& catalog) {
  const InputCounts& c = catalog.counts;
  core::log(
      "survey: {} vertices, {} triangles ({} polygons as fans, {} faces with fewer than 3 corners skipped)",
      c.vertices, c.triangles, c.polygons, c.small_faces);
  core::log("survey: bounds {} {} {} to {} {} {}", catalog.bounds.low[0], catalog.bounds.low[1],
            catalog.bounds.low[2], catalog.bounds.high[0], catalog.bounds.high[1], catalog.bounds.high[2]);
}

BuildReport run_phases(const Workspace& workspace, const Scheme& scheme) {
  const cluster::Communicator& ranks = workspace.ranks;
  Catalog catalog = survey(workspace);
  log_survey(catalog);
  catalog.lattice = geometry::Lattice::fit(catalog.bounds);
  core::log("lattice: step {} (input vertices moved by at most {}), origin {} {} {}", catalog.lattice.step,
            catalog.lattice.input_error(), catalog.lattice.origin[0], catalog.lattice.origin[1],
            catalog.lattice.origin[2]);
  const Hierarchy hierarchy = scheme.build(workspace, catalog);

  BuildReport report;
  report.input_triangles = catalog.counts.triangles;
  ranks.attempt([&] {
    if (ranks.is_root()) report.output_bytes = assemble(workspace, catalog, scheme.name, hierarchy);
  });
  report.nodes = hierarchy.nodes.size();
  broadcast_value(ranks, report);
  core::log("memory: at most {} per rank of {}", size_text(greatest_peak_memory(ranks)),
            size_text(workspace.memory_bytes));
  return report;
}

}  // namespace

BuildReport build(const cluster::Communicator& ranks, const BuildOptions& options) {
  check_options(ranks, options);
  const std::uint64_t memory_bytes = memory_per_rank(ranks, options.memory);
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
    report =
        run_phases({ranks, options, scratch, *writer, reader, memory_bytes}, scheme_named(options.scheme));
  }
  ranks.barrier();
  ranks.attempt([&] {
    if (ranks.is_root()) directory->remove();
  });
  return report;
}

}  // namespace colossus::build
