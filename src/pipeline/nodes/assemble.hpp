// The step assembly: one rank puts the finished nodes into the container.
#pragma once

#include "pipeline/facts/catalog.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::nodes {

// Writes options.output from the chunks in scratch and returns its size in bytes. On rank 0 only; not
// collective.
std::uint64_t assemble(const run::Workspace& workspace, const facts::Catalog& catalog, const char* scheme,
                       const facts::FinishedNodes& finished);

}  // namespace colossus::pipeline::nodes
