// The step survey: reads every input once, checks it, and copies its input blocks to scratch.
#pragma once

#include "pipeline/facts/catalog.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::ingest {

// The catalogue of input blocks with bounds and counts; the same on all ranks. Throws on bad data and when
// there is no triangle at all. Collective.
facts::Catalog survey(const run::Workspace& workspace);

}  // namespace colossus::pipeline::ingest
