// Phases 4 and 5: encodes the leaves, then simplifies level by level from the finest to the root.
#pragma once

#include "build/diamonds/node.hpp"
#include "build/diamonds/partition.hpp"

namespace colossus::build {

// Collective. Within a level nodes are independent tasks. Completes the catalogue's counts of the finest
// level. Throws Error(kUsage) when leaves do not keep --tolerance, Error(kBadData) when they lack surface.
Hierarchy build_levels(const Workspace& workspace, const NodeSettings& settings, const Partition& partition,
                       Catalog& catalog);

}  // namespace colossus::build
