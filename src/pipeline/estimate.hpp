// What a build will need, said before the work starts.
#pragma once

#include "pipeline/facts/catalog.hpp"
#include "pipeline/ingest/occupancy.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline {

// From the counts of the survey: meant to lie between 1.0 and 1.5 times what is used then. How the needs grow
// was measured, see src/README.md. `resident_bytes`: of the rank that has the largest resident set after the
// survey. Not collective.
run::BuildEstimate estimate(const facts::BuildOptions& options, const facts::Catalog& catalog,
                            const ingest::Occupancy& occupancy, std::uint64_t resident_bytes);

// Once the survey's and the requests' scratch is written, some 16 bytes per triangle beside the copy of the
// input. Logs the estimate and passes it to the reporter. `resident_bytes` as above. Throws
// Error(kNoResources) that tells what is needed and what there is when it cannot fit. Collective.
void announce_estimate(const run::Workspace& workspace, const facts::Catalog& catalog,
                       std::uint64_t resident_bytes);

}  // namespace colossus::pipeline
