// Simplifies level by level, from the cubes of the deepest to the root's.
#pragma once

#include "build/blocks/node.hpp"

namespace colossus::build {

// Collective. Within a level blocks are independent tasks. Sets all of the hierarchy but its options. Throws
// Error(kBadData) when the deepest level lacks surface.
Hierarchy build_block_levels(const Workspace& workspace, const BlockSettings& settings,
                             CubePartition&& partition, const Catalog& catalog);

}  // namespace colossus::build
