// Phases 4 and 5: encodes the leaves, then simplifies level by level from the finest to the root.
#pragma once

#include "build/diamonds/node.hpp"
#include "build/diamonds/partition.hpp"

namespace colossus::build {

// Collective. Within a level nodes are independent tasks.
Hierarchy build_levels(const Workspace& workspace, const NodeSettings& settings, const Partition& partition);

}  // namespace colossus::build
