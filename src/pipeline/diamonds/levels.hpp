// The step leaves and levels: encodes the leaves, then simplifies level by level from the finest to the root.
#pragma once

#include "pipeline/diamonds/node.hpp"
#include "pipeline/diamonds/partition.hpp"

namespace colossus::pipeline::diamonds {

// Collective. Within a level nodes are independent tasks. Completes the catalogue's counts of the finest
// level. Throws Error(kUsage) when leaves do not keep --tolerance, Error(kBadData) when they lack surface.
facts::FinishedNodes build_levels(const run::Workspace& workspace, const NodeSettings& settings,
                                  const Partition& partition, facts::Catalog& catalog);

}  // namespace colossus::pipeline::diamonds
