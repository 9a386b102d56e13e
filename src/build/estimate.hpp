// What a build will need, said before the work starts.
#pragma once

#include "build/catalog.hpp"
#include "build/reporter.hpp"
#include "build/workspace.hpp"

namespace colossus::build {

// From the counts of the survey. Scratch and output are meant to lie between 1.0 and 1.5 times what is used then;
// how they grow with counts, attributes, scheme and bits was measured (src/README.md). Free space is that of the file
// systems of scratch and output. Not collective.
BuildEstimate estimate(const Workspace& workspace, const Catalog& catalog);

// Logs the estimate. Throws Error(kNoResources) that tells what is needed and what there is when it cannot fit.
void require(const Workspace& workspace, const BuildEstimate& estimate);

}  // namespace colossus::build
