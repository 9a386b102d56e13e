// A node's payload into scratch, as the chunk that assembly copies.
#pragma once

#include "codec/payload.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::nodes {

// Packs the payload, appends it to this rank's spool, and fills in what the node's row and statistics say of
// it. Not collective.
void store_node(const run::Workspace& workspace, const codec::Codec& codec, const codec::Payload& payload,
                facts::FinishedNode& node);

}  // namespace colossus::pipeline::nodes
