// Start and end of a run on one or many ranks.
#pragma once

#include <functional>
#include <memory>

#include "cluster/communicator.hpp"

namespace colossus::cluster {

// MPI from construction to destruction; one per program. Collective at both ends.
//
// The program may be started by mpirun or srun, or alone: then it is rank 0 of 1, needs no daemon, and opens
// no network. Log lines are enabled on rank 0 only. The thread that makes the Session makes all calls to MPI.
// Destroyed by an exception that passes, it ends all ranks with status kInternal, since the other ranks would
// wait for ever: programs use run_ranks().
class Session {
 public:
  // Throws Error(kInternal) when there is a Session already, or was one.
  Session(int& argc, char**& argv);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  Communicator& world() { return *world_; }

 private:
  int exceptions_at_start_;
  std::unique_ptr<Communicator> world_;
};

// Throws Error(kUsage) when this process says that it is all there is, but was started as one of several: by
// srun or mpirun of an MPI that ours does not understand. Only what belongs to this start counts, never what
// the batch system has allocated. Not collective.
void refuse_lone_start(const Communicator& world);

// Runs `body` on every rank, and returns the exit status for main(): the largest status that any rank's body
// returned or failed with, on all ranks the same. Collective.
//
// A message is printed once, to stderr, but none of status kStopped, which is no error. If all ranks fail (an
// AgreedError, or the same error found by each), or the others come to the end of `body`, all ranks return in
// order. A rank that fails alone while others go on ends them all: after half a second it prints its message
// with its rank and calls MPI_Abort with its status. mpirun and srun add messages of their own to any status
// but 0.
int run_ranks(int& argc, char**& argv, const std::function<int(Communicator&)>& body);

}  // namespace colossus::cluster
