// Where a build writes, looked at before it touches anything.
#pragma once

#include <filesystem>

#include "cluster/communicator.hpp"
#include "core/outputs.hpp"
#include "pipeline/facts/options.hpp"

namespace colossus::pipeline::run {

// The places that the options name, with symbolic links followed.
struct Outputs {
  core::OutputTarget container;
  core::OutputTarget status;  // where they are asked for
  core::OutputTarget report;
  std::filesystem::path scratch;  // on all ranks; the others are known to rank 0 only
};

// The folder of scratch by the name that the user knows.
std::filesystem::path scratch_of(const facts::BuildOptions& options);

// Collective. Throws on all ranks like core::plan_outputs(), and Error(kBadData) for a list of inputs that
// cannot be read. Where stdout is the report, log lines go to stderr from then on.
Outputs plan_outputs(const cluster::Communicator& ranks, const facts::BuildOptions& options);

}  // namespace colossus::pipeline::run
