// The step leaves and levels: simplifies level by level, from the cubes of the deepest to the root's.
#pragma once

#include "pipeline/blocks/node.hpp"

namespace colossus::pipeline::blocks {

// Collective. Within a level blocks are independent tasks. Sets all of the finished nodes but their options.
// Throws Error(kBadData) when the deepest level lacks surface.
facts::FinishedNodes build_levels(const run::Workspace& workspace, const NodeSettings& settings,
                                  Partition&& partition, const facts::Catalog& catalog);

}  // namespace colossus::pipeline::blocks
