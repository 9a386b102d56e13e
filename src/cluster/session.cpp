#include "cluster/session.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "cluster/mpi_calls.hpp"
#include "cluster/stop_notices.hpp"
#include "core/hash.hpp"
#include "core/log.hpp"

namespace colossus::cluster {
namespace {

// How long a rank that failed alone waits for the others to come to the end, too.
constexpr std::chrono::milliseconds kGrace{500};

// The number that a variable holds, 0 for none.
long number_of(const char* variable) {
  const char* text = std::getenv(variable);
  return text == nullptr ? 0 : std::strtol(text, nullptr, 10);
}

// As the launcher has set it: MPI_Init sets it, too.
long pmix_rank_before_start = -1;

bool started_by_a_launcher() {
  constexpr std::array kVariables = {
      "OMPI_COMM_WORLD_SIZE", "PMIX_RANK",  "PMIX_NAMESPACE", "PMI_RANK", "PMI_FD", "PMI_SIZE",
      "SLURM_PROCID",         "ALPS_APP_PE"};
  return std::any_of(kVariables.begin(), kVariables.end(),
                     [](const char* name) { return std::getenv(name); });
}

// Open MPI's MPI_Init of a program that runs alone starts a daemon, looks for networks, and makes shared
// memory and a directory in TMPDIR. None of it is needed for one rank, and each can fail. A user's own
// settings stay.
void prepare_to_run_alone() {
  constexpr int kKeep = 0;
  setenv("OMPI_MCA_ess_singleton_isolated", "1", kKeep);
  setenv("OMPI_MCA_orte_create_session_dirs", "0", kKeep);
  setenv("OMPI_MCA_pml", "ob1", kKeep);
  setenv("OMPI_MCA_btl", "self", kKeep);
}

MPI_Comm duplicate_world() {
  MPI_Comm comm = MPI_COMM_NULL;
  check_mpi(MPI_Comm_dup(MPI_COMM_WORLD, &comm), "MPI_Comm_dup");
  check_mpi(MPI_Comm_set_errhandler(comm, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  return comm;
}

// How body() ended on this rank.
struct Outcome {
  int status = 0;
  std::string message;  // empty: nothing to print
  bool is_agreed = false;
};

// What each rank tells the others about its outcome.
struct Farewell {
  std::int64_t status;
  std::uint64_t message_hash;  // 0 for no message
  std::int64_t has_sent_stop;
};

Outcome run_body(Communicator& world, const std::function<int(Communicator&)>& body) {
  try {
    return {body(world), "", false};
  } catch (const AgreedError& error) {
    return {static_cast<int>(error.status()), error.what(), true};
  } catch (...) {
    const core::Error error = core::error_of_current_exception();
    return {static_cast<int>(error.status()), error.what(), false};
  }
}

void print_error(const std::string& where, const std::string& message) {
  std::fflush(stdout);
  const std::string line = fmt::format("colossus: error{}: {}\n", where, message);
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

std::string on_rank(int rank) { return fmt::format(" on rank {}", rank); }

// All ranks meet; a rank that failed alone ends everything when the others do not come. Returns the common
// status.
int say_farewell(const Communicator& world, const Outcome& outcome) {
  const Communicator::Impl& impl = world.impl();
  const std::span<const char> text(outcome.message);
  StopNotices* const stop = stop_notices();
  if (stop) stop->close();
  const Farewell mine{outcome.status,
                      text.empty() ? 0 : std::max<std::uint64_t>(1, core::hash64(core::as_bytes(text))),
                      stop && stop->has_sent() ? 1 : 0};
  std::vector<Farewell> all(static_cast<std::size_t>(impl.size));
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Iallgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, impl.farewell,
                           &request),
            "MPI_Iallgather");
  const bool is_lone_failure = !outcome.message.empty() && !outcome.is_agreed;
  const auto limit = is_lone_failure ? std::optional(kGrace) : std::nullopt;
  if (!wait_politely(request, limit)) {
    print_error(on_rank(impl.rank), outcome.message);
    MPI_Abort(MPI_COMM_WORLD, outcome.status);
  }
  // Each message once, from the lowest rank that has it, before any rank exits: mpirun may then end the
  // others.
  const auto has_mine = [&](const Farewell& other) { return other.message_hash == mine.message_hash; };
  const bool is_to_be_told =
      mine.message_hash != 0 && mine.status != static_cast<int>(core::Status::kStopped);
  if (is_to_be_told && std::none_of(all.begin(), all.begin() + impl.rank, has_mine))
    print_error(std::all_of(all.begin(), all.end(), has_mine) ? "" : on_rank(impl.rank), outcome.message);
  if (stop) {
    const auto has_sent = [](const Farewell& other) { return other.has_sent_stop != 0; };
    stop->finish(static_cast<int>(std::count_if(all.begin() + 1, all.end(), has_sent)), has_sent(all[0]));
  }
  world.barrier();
  int status = 0;
  for (const Farewell& other : all) status = std::max(status, static_cast<int>(other.status));
  return status;
}

}  // namespace

Session::Session(int& argc, char**& argv) : exceptions_at_start_(std::uncaught_exceptions()) {
  int initialized = 0;
  MPI_Initialized(&initialized);
  if (initialized != 0) core::fail(core::Status::kInternal, "MPI is initialised twice");
  pmix_rank_before_start = number_of("PMIX_RANK");
  if (!started_by_a_launcher()) prepare_to_run_alone();
  int provided = MPI_THREAD_SINGLE;
  check_mpi(MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
  auto impl = std::make_unique<Communicator::Impl>();
  impl->collective = duplicate_world();
  impl->farm = duplicate_world();
  impl->farewell = duplicate_world();
  impl->stop = duplicate_world();
  check_mpi(MPI_Comm_rank(impl->collective, &impl->rank), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(impl->collective, &impl->size), "MPI_Comm_size");
  core::set_log_enabled(impl->rank == 0);
  world_ = std::make_unique<Communicator>(std::move(impl));
}

Session::~Session() {
  if (std::uncaught_exceptions() > exceptions_at_start_)
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(core::Status::kInternal));
  Communicator::Impl& impl = world_->impl();
  for (MPI_Comm* comm : {&impl.collective, &impl.farm, &impl.farewell, &impl.stop}) MPI_Comm_free(comm);
  MPI_Finalize();
}

void refuse_lone_start(const Communicator& world) {
  // mpirun of our MPI says how many there are, and has made the world so.
  if (world.size() > 1 || std::getenv("OMPI_COMM_WORLD_SIZE")) return;
  const long count = std::max({number_of("SLURM_STEP_NUM_TASKS"), number_of("PMI_SIZE"), 1L});
  const bool is_one_of_several = count > 1 || pmix_rank_before_start > 0 || number_of("PMI_RANK") > 0;
  if (!is_one_of_several) return;
  core::fail(
      core::Status::kUsage,
      "{} programs of one rank each were started instead of one program of several ranks, and would do "
      "the same work: start them with srun --mpi=pmix, or with mpirun; to start a single one, say srun -n 1",
      count > 1 ? fmt::format("{}", count) : "several");
}

int run_ranks(int& argc, char**& argv, const std::function<int(Communicator&)>& body) {
  Session session(argc, argv);
  Communicator& world = session.world();
  return say_farewell(world, run_body(world, body));
}

}  // namespace colossus::cluster
