// A program whose ranks fail in the way that its argument names; see check_ending.cmake.
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>

#include "cluster/farm.hpp"
#include "cluster/session.hpp"

namespace {

using colossus::cluster::Communicator;
using colossus::core::Bytes;
using colossus::core::Error;
using colossus::core::Status;

int failing_rank(const Communicator& ranks) { return ranks.size() == 1 ? 0 : 1; }

// Many tasks, the fifth of which calls `fail`.
void run_farm_that_fails(const Communicator& ranks, const std::function<void()>& fail) {
  const auto work = [&](std::span<const std::byte> task) -> Bytes {
    if (task.size() == 5) fail();
    return {};
  };
  colossus::cluster::run_farm(
      ranks, 50, [](std::size_t task) { return Bytes(task); }, work, [](std::size_t, Bytes) {});
}

using Mode = std::function<int(Communicator&)>;

const std::map<std::string, Mode> kModes = {
    {"success", [](Communicator&) { return 0; }},
    {"agreed",
     [](Communicator& ranks) {
       ranks.attempt([&] {
         if (ranks.rank() == failing_rank(ranks)) throw Error(Status::kBadData, "scan.ply: face 7");
       });
       return 0;
     }},
    {"same", [](Communicator&) -> int { throw Error(Status::kUsage, "unknown option"); }},
    {"lone",
     [](Communicator& ranks) {
       if (ranks.rank() == failing_rank(ranks)) throw Error(Status::kBadData, "scan.ply: face 8");
       ranks.barrier();
       return 0;
     }},
    {"lone_at_the_end",
     [](Communicator& ranks) {
       if (ranks.rank() == 1) throw Error(Status::kBadData, "scan.ply: face 9");
       return 0;
     }},
    {"exception",
     [](Communicator& ranks) {
       if (ranks.rank() == 1) throw std::logic_error("a bug");
       ranks.barrier();
       return 0;
     }},
    // The largest status wins on all ranks: mpirun returns that of the rank that exits first.
    {"status",
     [](Communicator& ranks) {
       return std::array{0, 2, 65}[static_cast<std::size_t>(ranks.rank())];
     }},
    {"farm",
     [](Communicator& ranks) {
       run_farm_that_fails(ranks, [] { throw Error(Status::kNoResources, "no space for node 5"); });
       return 0;
     }},
    {"exit",
     [](Communicator& ranks) {
       run_farm_that_fails(ranks, [] { _exit(3); });
       return 0;
     }},
    {"kill",
     [](Communicator& ranks) {
       run_farm_that_fails(ranks, [] { raise(SIGKILL); });
       return 0;
     }},
    {"kill_master",
     [](Communicator& ranks) {
       if (ranks.is_root()) raise(SIGKILL);
       ranks.barrier();
       return 0;
     }},
    {"check",
     [](Communicator& ranks) {
       const int one = 1;
       run_farm_that_fails(ranks, [&] { COLOSSUS_CHECK(1 == 2, "{}", one); });
       return 0;
     }},
};

}  // namespace

int main(int argc, char** argv) {
  const auto mode = argc == 2 ? kModes.find(argv[1]) : kModes.end();
  if (mode == kModes.end()) {
    std::fprintf(stderr, "usage: failing_ranks MODE\n");
    return 2;
  }
  return colossus::cluster::run_ranks(argc, argv, mode->second);
}
