// Simplifies level by level, from the cubes of the deepest to the root's.
#pragma once

#include "build/blocks/node.hpp"

namespace colossus::build {

// Collective. Within a level blocks are independent tasks. Sets the hierarchy's nodes, levels, and the
// parameters sigma0 and block_size.
Hierarchy build_block_levels(const Workspace& workspace, const BlockSettings& settings,
                             CubePartition&& partition);

}  // namespace colossus::build
