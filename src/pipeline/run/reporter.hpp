// What a build says of itself while it runs and afterwards: log lines, --status and --report. Nothing of it
// reaches the container.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "cluster/communicator.hpp"
#include "core/error.hpp"
#include "pipeline/facts/catalog.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/facts/options.hpp"
#include "pipeline/run/outputs.hpp"

namespace colossus::pipeline::run {

// Of one rank in one phase.
struct PhaseShare {
  std::uint64_t tasks = 0;          // that it worked on
  std::uint64_t triangles = 0;      // that went into them
  std::uint64_t scratch_bytes = 0;  // that it appended
  std::uint64_t peak_memory_bytes = 0;
  double work_seconds = 0.0;
};

// Sums, in the units of the report; see schemas/report.schema.json.
struct BuildEstimate {
  std::uint64_t memory_bytes_per_rank = 0;
  std::uint64_t scratch_bytes = 0;
  std::uint64_t output_bytes = 0;
  std::uint64_t free_scratch_bytes = 0;
  std::uint64_t free_output_bytes = 0;
};

class Reporter {
 public:
  // Collective. Throws Error(kCannotCreate) on all ranks when --status or --report name files that cannot be
  // written: better now than after hours. A report to a pipe or a device is written once, at the end.
  Reporter(const cluster::Communicator& ranks, const facts::BuildOptions& options, const Outputs& outputs);

  // Not collective: what the task at hand has to do.
  void add_triangles(std::uint64_t count) { triangles_ += count; }

  // The following do nothing but on rank 0.
  void begin_phase(const std::string& name, std::size_t task_count, std::size_t resumed_count);
  // After each task; writes a log line every half minute, and the status file every second.
  void finish_task();
  void set_attempt(int attempt) { attempt_ = attempt; }
  void set_estimate(const BuildEstimate& estimate) { estimate_ = estimate; }
  // Of all ranks, now.
  void note_scratch(std::uint64_t bytes) { most_scratch_bytes_ = std::max(most_scratch_bytes_, bytes); }
  void set_input(const facts::Catalog& catalog);
  void set_output(const facts::FinishedNodes& finished, std::uint64_t output_bytes);

  // Collective. Ends the phase; `mine` without triangles and memory, which this knows.
  void end_phase(PhaseShare mine);

  // Collective. Writes the last status and the report; `failure` is how the build ended, if not well.
  // Failures to write are warnings: the container is complete all the same, and files could be written
  // before. But when a build that ended well cannot write to a pipe or a device, all ranks throw
  // Error(kNoResources) or Error(kIo). Waits for the reader of a pipe until a stop is requested.
  void finish(const core::Error* failure);

 private:
  struct Phase {
    std::string name;
    std::size_t tasks = 0;
    std::size_t resumed = 0;
    double seconds = 0.0;
    std::vector<PhaseShare> shares;  // by rank; empty when the phase was not finished
  };
  using Clock = std::chrono::steady_clock;

  std::string status_json(const char* state) const;
  std::string report_json(const core::Error* failure) const;
  void write_status(const char* state);
  void replace_or_warn(const core::OutputTarget& file, const std::string& text);
  void write_last(const core::Error* failure);
  std::string progress_line() const;
  double phase_seconds() const;

  const cluster::Communicator& ranks_;
  const facts::BuildOptions& options_;
  const Outputs& outputs_;
  std::vector<std::string> hosts_;  // by rank
  std::string begin_;               // ISO time
  std::uint64_t triangles_ = 0;     // of the phase at hand, on this rank
  std::vector<Phase> phases_;       // the last one is at hand
  std::size_t done_ = 0;            // of its tasks
  Clock::time_point phase_begin_;
  Clock::time_point last_line_;
  Clock::time_point last_status_;
  std::vector<std::uint64_t> peak_memory_;  // by rank, bytes
  BuildEstimate estimate_;
  int attempt_ = 1;
  std::uint64_t most_scratch_bytes_ = 0;
  std::vector<facts::InputFile> inputs_;
  facts::InputCounts counts_;
  std::vector<facts::LevelStatistics> levels_;
  std::uint64_t node_count_ = 0;
  std::uint64_t output_bytes_ = 0;
  bool is_complete_ = false;
  bool has_warned_ = false;
};

}  // namespace colossus::pipeline::run
