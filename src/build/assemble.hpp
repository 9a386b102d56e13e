// Phase 6: one rank puts the finished nodes into the container.
#pragma once

#include "build/catalog.hpp"
#include "build/hierarchy.hpp"
#include "build/workspace.hpp"

namespace colossus::build {

// Writes options.output from the chunks in scratch and returns its size in bytes. On rank 0 only; not
// collective.
std::uint64_t assemble(const Workspace& workspace, const Catalog& catalog, const char* scheme,
                       const Hierarchy& hierarchy);

}  // namespace colossus::build
