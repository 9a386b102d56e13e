// The whole build: from input files to one container.
#pragma once

#include "cluster/communicator.hpp"
#include "pipeline/facts/options.hpp"

namespace colossus::pipeline {

struct BuildReport {
  std::uint64_t input_triangles = 0;
  std::uint64_t nodes = 0;
  std::uint64_t output_bytes = 0;
  bool is_dry_run = false;  // nothing was built
};

// Throws Error(kUsage) for options that no build can have, whatever the input. Not collective.
void check_options(const facts::BuildOptions& options);

// Builds asked.output. Collective, once per program: signals to stop are watched for from then on. On any
// error no output is left behind. Scratch is left for a later attempt with asked.resume, unless a first
// attempt fails with status kUsage or kBadData, which another one would meet again.
BuildReport build(const cluster::Communicator& ranks, const facts::BuildOptions& asked);

}  // namespace colossus::pipeline
