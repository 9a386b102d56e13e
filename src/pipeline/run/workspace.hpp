// What every phase of a build needs: the ranks, this rank's spools, a reader of all spools, the options.
#pragma once

#include "cluster/communicator.hpp"
#include "core/bytes.hpp"
#include "pipeline/facts/options.hpp"
#include "pipeline/run/outputs.hpp"
#include "pipeline/run/reporter.hpp"
#include "scratch/spool.hpp"

namespace colossus::pipeline::run {

struct Progress;  // for run_phase()

struct Workspace {
  const cluster::Communicator& ranks;
  const facts::BuildOptions& options;
  scratch::Location scratch;
  scratch::SpoolWriter& writer;
  scratch::SpoolReader& reader;
  std::uint64_t memory_bytes;  // that this rank may use
  Progress& progress;
  Reporter& reporter;
  const Outputs& outputs;
};

}  // namespace colossus::pipeline::run
