// A task farm: rank 0 hands out independent tasks, the other ranks do them.
//
// Each worker holds up to two tasks, the one that it works on and the next, so that it does not idle while
// its result travels. Nothing blocks and nothing spins: rank 0 needs little of the core that it shares with a
// worker. A task should cost milliseconds; large data should go through scratch files, not through rank 0.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "cluster/communicator.hpp"
#include "core/bytes.hpp"

namespace colossus::cluster {

// Called on rank 0, once per task, in the order 0, 1, 2, ..., not before the task is about to be sent.
using MakeTask = std::function<core::Bytes(std::size_t task)>;
// Called on any rank but 0 (on 0 if it is alone), with the bytes that make_task returned.
using Work = std::function<core::Bytes(std::span<const std::byte> task)>;
// Called on rank 0, once per task, in the order in which results arrive: not the order of the tasks.
using TakeResult = std::function<void(std::size_t task, core::Bytes result)>;

// What this rank did.
struct FarmShare {
  std::size_t task_count = 0;  // tasks that it worked on
  double work_seconds = 0.0;   // time inside work()
  double total_seconds = 0.0;  // from the call of run_farm() to its return
};

// Collective. Runs all tasks, unless a stop is requested (see cluster/stop.hpp): then no further task starts,
// those that run are finished, and run_farm() throws an AgreedError of status kStopped on all ranks. Only
// rank 0's `task_count`, `make_task` and `on_result` are used. The callbacks must not make collective calls.
//
// An exception from any callback is data: no further task starts, those that run are finished, their results
// dropped, and run_farm() throws the same AgreedError on all ranks, with the status of the Error and its
// message followed by task and rank. Of several failures, one of rank 0's callbacks comes first, then the one
// of the lowest task. Exceptions other than Error: see core::error_of_current_exception().
FarmShare run_farm(const Communicator& ranks, std::size_t task_count, const MakeTask& make_task,
                   const Work& work, const TakeResult& on_result);

}  // namespace colossus::cluster
