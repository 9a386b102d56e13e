#include "pipeline/build.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cluster/stop.hpp"
#include "core/duration.hpp"
#include "core/log.hpp"
#include "core/version.hpp"
#include "pipeline/estimate.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/ingest/extent.hpp"
#include "pipeline/ingest/survey.hpp"
#include "pipeline/nodes/assemble.hpp"
#include "pipeline/nodes/finest_level.hpp"
#include "pipeline/run/inputs.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/run/phase.hpp"
#include "pipeline/run/restart.hpp"
#include "pipeline/schemes.hpp"

namespace colossus::pipeline {
namespace {

constexpr std::uint64_t kLeastLeafTriangles = 16;
constexpr std::uint64_t kMostLeafTriangles = 1'000'000'000;  // a leaf is made in memory

std::optional<double> seconds_of(const std::optional<std::string>& time_limit) {
  if (!time_limit) return std::nullopt;
  const std::optional<double> seconds = core::parse_duration(*time_limit);
  if (!seconds)
    core::fail(core::Status::kUsage,
               "--time-limit {} is no time; write it like 90s, 45m, 3h50m or 1-02:00:00", *time_limit);
  return seconds;
}

void log_survey(const facts::Catalog& catalog) {
  const facts::InputCounts& c = catalog.counts;
  core::log(
      "survey: {} vertices, {} triangles (polygons among the faces: {}; with fewer than 3 corners, skipped: "
      "{})",
      c.vertices, c.triangles, c.polygons, c.small_faces);
}

void log_polygons(const cluster::Communicator& ranks, const facts::Catalog& catalog) {
  if (!ranks.is_root()) return;
  const facts::InputCounts& c = catalog.counts;
  if (c.concave_polygons > 0) core::log("polygons: {} of {} are concave", c.concave_polygons, c.polygons);
  if (c.warped_polygons > 0)
    core::warn("{}: {} of {} polygons are warped: their corners lie far off their own plane",
               catalog.input_name(), c.warped_polygons, c.polygons);
  if (c.crossing_polygons > 0)
    core::warn("{}: {} of {} polygons cross themselves, and are triangulated as well as can be",
               catalog.input_name(), c.crossing_polygons, c.polygons);
}

void log_lattice(const facts::Catalog& catalog) {
  const geometry::Bounds& bounds = catalog.bounds;
  core::log("extent: {} {} {} to {} {} {}", bounds.low[0], bounds.low[1], bounds.low[2], bounds.high[0],
            bounds.high[1], bounds.high[2]);
  core::log("lattice: step {} (input vertices moved by at most {}), origin {} {} {}", catalog.lattice.step,
            catalog.lattice.input_error(), catalog.lattice.origin[0], catalog.lattice.origin[1],
            catalog.lattice.origin[2]);
}

BuildReport run_phases(const run::Workspace& workspace, const nodes::Scheme& scheme,
                       const std::vector<run::InputStamp>& inputs) {
  const cluster::Communicator& ranks = workspace.ranks;
  facts::Catalog catalog = ingest::survey(workspace);
  ranks.attempt([&] {
    if (ranks.is_root()) check_unchanged(inputs);
  });
  log_survey(catalog);
  const std::uint32_t survey_phase = last_phase(workspace);
  const std::uint64_t resident_bytes = run::greatest_peak_memory(ranks);
  std::vector<ingest::TriangleGroup> groups = ingest::request_vertices(workspace, catalog);
  measure_extent(workspace, catalog, groups);
  catalog.lattice = geometry::Lattice::fit(catalog.bounds);
  log_lattice(catalog);
  workspace.reporter.set_input(catalog);
  announce_estimate(workspace, catalog, resident_bytes);

  BuildReport report;
  report.input_triangles = catalog.counts.triangles;
  report.is_dry_run = workspace.options.is_dry_run;
  if (report.is_dry_run) return report;
  answer_requests(workspace, catalog, groups);
  release_phases_up_to(workspace, survey_phase);
  cut_polygons(workspace, catalog, groups);
  log_polygons(ranks, catalog);
  measure_median_edge(workspace, catalog, groups);
  ranks.attempt(
      [&] { ingest::refuse_far_corner(workspace.options, catalog, 2.0 * catalog.lattice.input_error()); });
  const facts::FinishedNodes finished = scheme.build(workspace, catalog, std::move(groups));
  if (ranks.is_root()) nodes::count_finest_level(catalog, finished);
  workspace.reporter.set_input(catalog);
  ranks.attempt([&] {
    if (ranks.is_root()) report.output_bytes = nodes::assemble(workspace, catalog, scheme.name, finished);
  });
  workspace.reporter.end_phase({});
  workspace.reporter.set_output(finished, report.output_bytes);
  report.nodes = finished.nodes.size();
  broadcast_value(ranks, report);
  core::log("memory: at most {} per rank of {}", run::size_text(run::greatest_peak_memory(ranks)),
            run::size_text(workspace.memory_bytes));
  return report;
}

// How an attempt at a build ended.
struct Attempt {
  std::uint16_t number = 0;
  bool is_resumed = false;
  bool is_superseded = false;
  BuildReport report;
  std::optional<core::Error> failure;

  // Whether scratch is of no use any more. After bad input or usage another attempt would find the same
  // fault; but what earlier ones have finished is not lost to a file system that lets go of an input for a
  // while, nor to a dry run.
  bool is_done_with_scratch() const {
    if (is_superseded) return false;
    if (!failure) return !(report.is_dry_run && is_resumed);
    if (failure->status() == core::Status::kUsage) return true;
    return failure->status() == core::Status::kBadData && !is_resumed;
  }
};

// The failure with what to do next.
cluster::AgreedError with_advice(const Attempt& attempt, const std::filesystem::path& scratch) {
  const core::Error& error = *attempt.failure;
  if (attempt.is_superseded || attempt.is_done_with_scratch()) return {error.status(), error.what()};
  if (error.status() == core::Status::kStopped)
    return {error.status(),
            fmt::format("{}; what is finished lies in {}: run the same command with --resume to "
                        "continue",
                        error.what(), scratch.string())};
  return {error.status(), fmt::format("{}; what is finished lies in {}: once the cause is gone, run the same "
                                      "command with --resume to continue, or remove that directory",
                                      error.what(), scratch.string())};
}

// Collective. Failures to open scratch are thrown, but a request to stop: there may be much to look at.
Attempt attempt_build(const cluster::Communicator& ranks, const facts::BuildOptions& options,
                      const run::Outputs& outputs, std::uint64_t memory_bytes, run::Reporter& reporter) {
  std::vector<run::InputStamp> inputs;
  ranks.attempt([&] {
    if (ranks.is_root()) inputs = run::stamps_of_inputs(options);
  });
  Attempt attempt;
  std::optional<run::OpenedScratch> opened;
  try {
    opened.emplace(run::open_scratch(ranks, outputs.scratch, options.resume, manifest_of(options, inputs),
                                     !options.scratch));
  } catch (const cluster::AgreedError& error) {
    if (error.status() != core::Status::kStopped) throw;
    attempt.failure = error;
    return attempt;
  }
  attempt.number = opened->progress.journal.attempt();
  attempt.is_resumed = opened->progress.is_resumed;
  reporter.set_attempt(attempt.number);
  scratch::SpoolWriter writer(opened->location, attempt.number, static_cast<std::uint16_t>(ranks.rank()));
  scratch::SpoolReader reader(opened->location);
  const run::Workspace workspace{ranks,        options,          opened->location, writer, reader,
                                 memory_bytes, opened->progress, reporter,         outputs};
  try {
    attempt.report = run_phases(workspace, scheme_named(options.scheme), inputs);
  } catch (const cluster::AgreedError& error) {
    std::uint32_t superseded = is_superseded(workspace) ? 1 : 0;
    broadcast_value(ranks, superseded);
    attempt.is_superseded = superseded != 0;
    attempt.failure = error;
    if (attempt.is_superseded) attempt.failure = superseded_error(workspace);
  }
  return attempt;
}

BuildReport build_with(const cluster::Communicator& ranks, const facts::BuildOptions& options,
                       const run::Outputs& outputs, run::Reporter& reporter) {
  const std::uint64_t memory_bytes = run::memory_per_rank(ranks, options.memory);
  cluster::watch_for_stop(ranks, seconds_of(options.time_limit));
  const Attempt attempt = attempt_build(ranks, options, outputs, memory_bytes, reporter);
  ranks.barrier();  // all files are closed
  if (ranks.is_root() && attempt.is_done_with_scratch()) {
    try {
      scratch::remove_scratch_directory(outputs.scratch, attempt.number);
    } catch (const core::Error& error) {
      core::warn_line(error.what());  // the container is complete all the same
    }
  }
  if (!attempt.failure) return attempt.report;
  const cluster::AgreedError agreed = with_advice(attempt, run::scratch_of(options));
  if (agreed.status() == core::Status::kStopped) core::log_line(agreed.what());
  throw agreed;
}

}  // namespace

void check_options(const facts::BuildOptions& options) {
  if (options.leaf_triangles < kLeastLeafTriangles || options.leaf_triangles > kMostLeafTriangles)
    core::fail(core::Status::kUsage, "--leaf-triangles {} is out of range; choose {} to {}",
               options.leaf_triangles, kLeastLeafTriangles, kMostLeafTriangles);
  if (options.tolerance && !(std::isfinite(*options.tolerance) && *options.tolerance > 0.0))
    core::fail(core::Status::kUsage, "--tolerance {} is not a positive length", *options.tolerance);
  codec::codec_named(options.codec);
  if (options.position_bits < codec::coded::kMinPositionBits ||
      options.position_bits > codec::coded::kMaxPositionBits)
    core::fail(core::Status::kUsage, "--position-bits {} is out of range; choose {} to {}",
               options.position_bits, codec::coded::kMinPositionBits, codec::coded::kMaxPositionBits);
  seconds_of(options.time_limit);
  const nodes::Scheme& scheme = scheme_named(options.scheme);
  refuse_options_of_other_schemes(options);
  if (scheme.check != nullptr) scheme.check(options);
}

BuildReport build(const cluster::Communicator& ranks, const facts::BuildOptions& asked) {
  ranks.attempt([&] { check_options(asked); });
  facts::BuildOptions options = asked;
  const nodes::Scheme& scheme = scheme_named(asked.scheme);
  options.scheme = scheme.name;
  std::erase_if(options.of_scheme, [&](const auto& given) {  // what another scheme has by default
    return std::none_of(scheme.options.begin(), scheme.options.end(),
                        [&](const facts::SchemeOption& option) { return option.name == given.first; });
  });
  complete(scheme.options, options.of_scheme);
  const run::Outputs outputs = run::plan_outputs(ranks, options);
  core::log("colossus {} build, {} ranks, leaf triangles {}", core::release_version(), ranks.size(),
            options.leaf_triangles);
  run::Reporter reporter(ranks, options, outputs);
  BuildReport report;
  std::optional<cluster::AgreedError> failure;
  try {
    report = build_with(ranks, options, outputs, reporter);
  } catch (const cluster::AgreedError& error) {
    failure = error;
  }
  reporter.finish(failure ? &*failure : nullptr);
  if (failure) throw *failure;
  return report;
}

}  // namespace colossus::pipeline
