// A phase of a build: independent tasks whose results come together on rank 0.
#pragma once

#include <cstdint>
#include <string>

#include "cluster/farm.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::run {

// Collective. Runs the tasks in the farm, see cluster::run_farm(). `name` is that of no other phase of the
// build. Results must depend on nothing but the input, the options and the results of earlier phases; what is
// large goes to scratch, with a reference to it in the result.
//
// A task that a rank has finished is recorded in its journal before the result is sent. In a resumed build
// on_result gets the recorded results first, by task; only tasks that have none, or that make_task makes
// otherwise than before, go to the farm. So make_task may be called twice for a task, with the same outcome,
// and results come in no particular order.
void run_phase(const Workspace& workspace, const std::string& name, std::size_t task_count,
               const cluster::MakeTask& make_task, const cluster::Work& work,
               const cluster::TakeResult& on_result);

// Not collective. The number of the phase that was run last, from 1; 0 before the first.
std::uint32_t last_phase(const Workspace& workspace);

// Collective. Deletes what the phases `first` to `last` have appended to scratch, but for kept records: no
// later phase than the one that was run last reads it. That one is none of them.
void release_phases(const Workspace& workspace, std::uint32_t first, std::uint32_t last);
// The same for all phases up to `last` that were not released by this function before.
void release_phases_up_to(const Workspace& workspace, std::uint32_t last);

// Not collective. Whether another attempt at this build has begun: it has taken over what this one has done,
// and the output is its own.
bool is_superseded(const Workspace& workspace);
// Throws superseded_error(), of status kIo, if so.
void check_not_superseded(const Workspace& workspace);
core::Error superseded_error(const Workspace& workspace);

}  // namespace colossus::pipeline::run
