// Phase 1: reads every input once, checks it, and copies its blocks to scratch.
#pragma once

#include "build/catalog.hpp"
#include "build/workspace.hpp"

namespace colossus::build {

// The catalogue of raw blocks with bounds and counts; the same on all ranks. Throws on bad data and when
// there is no triangle at all. Collective.
Catalog survey(const Workspace& workspace);

}  // namespace colossus::build
