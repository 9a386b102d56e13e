// The whole build: from input files to one container.
#pragma once

#include "build/options.hpp"
#include "cluster/communicator.hpp"

namespace colossus::build {

struct BuildReport {
  std::uint64_t input_triangles = 0;
  std::uint64_t nodes = 0;
  std::uint64_t output_bytes = 0;
};

// Builds options.output. Collective. On any error nothing is left behind: neither the output nor scratch.
BuildReport build(const cluster::Communicator& ranks, const BuildOptions& options);

}  // namespace colossus::build
