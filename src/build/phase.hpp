// A phase of a build: independent tasks whose results come together on rank 0.
#pragma once

#include <string>

#include "build/workspace.hpp"
#include "cluster/farm.hpp"

namespace colossus::build {

// Collective. Runs the tasks in the farm, see cluster::run_farm(). `name` is that of no other phase of the
// build. Results must depend on nothing but the input, the options and the results of earlier phases; what is
// large goes to scratch, with a reference to it in the result.
void run_phase(const Workspace& workspace, const std::string& name, std::size_t task_count,
               const cluster::MakeTask& make_task, const cluster::Work& work,
               const cluster::TakeResult& on_result);

}  // namespace colossus::build
