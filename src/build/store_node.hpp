// A node's payload into scratch, as the chunk that assembly copies.
#pragma once

#include "build/hierarchy.hpp"
#include "build/workspace.hpp"
#include "codec/payload.hpp"

namespace colossus::build {

// Packs the payload, appends it to this rank's spool, and fills in what the node's row and statistics say of
// it. Not collective.
void store_node(const Workspace& workspace, const codec::Codec& codec, const codec::Payload& payload,
                FinishedNode& node);

}  // namespace colossus::build
