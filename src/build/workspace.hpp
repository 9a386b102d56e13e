// What every phase of a build needs: the ranks, this rank's spools, a reader of all spools, the options.
#pragma once

#include "build/options.hpp"
#include "build/outputs.hpp"
#include "build/reporter.hpp"
#include "cluster/communicator.hpp"
#include "core/bytes.hpp"
#include "scratch/spool.hpp"

namespace colossus::build {

struct Progress;  // for run_phase()

struct Workspace {
  const cluster::Communicator& ranks;
  const BuildOptions& options;
  scratch::Location scratch;
  scratch::SpoolWriter& writer;
  scratch::SpoolReader& reader;
  std::uint64_t memory_bytes;  // that this rank may use
  Progress& progress;
  Reporter& reporter;
  const Outputs& outputs;
};

// Sends what rank 0 has to all ranks. Collective.
template <typename T>
void broadcast_values(const cluster::Communicator& ranks, std::vector<T>& values) {
  core::Bytes bytes;
  if (ranks.is_root()) {
    const auto view = core::as_bytes(values);
    bytes.assign(view.begin(), view.end());
  }
  ranks.broadcast(bytes);
  core::ByteReader reader(bytes);
  values = reader.get_array<T>(bytes.size() / sizeof(T));
}

template <typename T>
void broadcast_value(const cluster::Communicator& ranks, T& value) {
  std::vector<T> values{value};
  broadcast_values(ranks, values);
  value = values.at(0);
}

}  // namespace colossus::build
