// Runs the levels of any scheme, from the finest to the root: what no scheme does in a way of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cluster/farm.hpp"
#include "pipeline/facts/catalog.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::nodes {

// Made into a task's bytes when it is about to be sent.
struct PlannedTask {
  std::size_t index = 0;
  std::uint64_t triangles = 0;  // that go into it: what its cost and its memory grow with
};

// The tasks of one level, each of which makes one node or more. All but `name` and `work` are rank 0's.
struct Level {
  std::string name;  // of the phase, and in the log: "level 3"
  std::vector<PlannedTask> tasks;
  const char* task_name = "";                                        // "a diamond", in messages
  std::function<std::uint64_t(std::uint64_t triangles)> task_bytes;  // of memory, for require_memory()
  std::function<core::Bytes(std::size_t index)> make;
  cluster::Work work;
  // Takes what the scheme keeps of a result, and returns its nodes.
  std::function<std::vector<facts::FinishedNode>(std::span<const std::byte> result)> take;
  std::function<std::string(std::uint64_t nodes)> nodes_text;  // "12 cubes in 3 blocks"; else "12 nodes"
  std::optional<std::uint32_t> simplified;  // the level whose target this one's tasks had, if any
};

class LevelDriver {
 public:
  explicit LevelDriver(const run::Workspace& workspace) : workspace_(workspace) {}

  // As one phase, the largest tasks first, so that none of them starts last. Adds the nodes, logs the level,
  // and warns where it has missed its target. Collective.
  void run(Level level);

  // Once the finest level is made. Throws Error(kUsage) when --tolerance is not kept, Error(kBadData) when it
  // lacks surface, and what `check` throws, which is called on rank 0 before. Collective.
  void finish_finest(const facts::Catalog& catalog, const std::function<void()>& check = {});

  facts::FinishedNodes& finished() { return finished_; }
  // All of it, ordered.
  facts::FinishedNodes take();

 private:
  const run::Workspace& workspace_;
  facts::FinishedNodes finished_;
};

}  // namespace colossus::pipeline::nodes
