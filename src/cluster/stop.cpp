#include "cluster/stop.hpp"

#include <csignal>
#include <memory>

#include "cluster/mpi_calls.hpp"
#include "cluster/stop_notices.hpp"
#include "core/log.hpp"

namespace colossus::cluster {
namespace {

constexpr int kNoticeTag = 1;

volatile std::sig_atomic_t received_signal = 0;

extern "C" void note_signal(int signal) { received_signal = signal; }

// One per process, as signals are.
std::unique_ptr<StopNotices>& notices() {
  static std::unique_ptr<StopNotices> instance;
  return instance;
}

std::string name_of(int signal) {
  if (signal == SIGUSR1) return "SIGUSR1";
  if (signal == SIGUSR2) return "SIGUSR2";
  return signal == SIGTERM ? "SIGTERM" : fmt::format("signal {}", signal);
}

}  // namespace

std::string StopNotice::text() const {
  if (signal == 0) return "stopped: the time limit is reached";
  return fmt::format("stopped by {} to rank {}", name_of(signal), rank);
}

StopNotices::StopNotices(MPI_Comm comm, int rank, int size, std::optional<double> limit_seconds)
    : comm_(comm), rank_(rank), size_(size), limit_seconds_(limit_seconds) {
  start_receive();
}

const std::optional<StopNotice>& StopNotices::poll() {
  if (notice_ || is_closed_) return notice_;
  receive();
  if (!notice_ && received_signal != 0) notice_ = StopNotice{received_signal, rank_};
  if (!notice_ && rank_ == 0 && limit_seconds_ && core::elapsed_seconds() > *limit_seconds_)
    notice_ = StopNotice{0, 0};
  if (notice_) send();
  return notice_;
}

void StopNotices::start_receive() {
  if (size_ > 1)
    check_mpi(MPI_Irecv(&incoming_, sizeof incoming_, MPI_BYTE, rank_ == 0 ? MPI_ANY_SOURCE : 0, kNoticeTag,
                        comm_, &receive_request_),
              "MPI_Irecv");
}

void StopNotices::receive() {
  if (receive_request_ == MPI_REQUEST_NULL) return;
  int arrived = 0;
  check_mpi(MPI_Test(&receive_request_, &arrived, MPI_STATUS_IGNORE), "MPI_Test");
  if (arrived == 0) return;
  ++received_count_;
  notice_ = incoming_;
}

// Rank 0 tells all others, the one from which it knows, too; the others tell rank 0 what they have found
// themselves.
void StopNotices::send() {
  if (rank_ != 0 && received_count_ > 0) return;
  has_sent_ = true;
  outgoing_ = *notice_;
  const int first = rank_ == 0 ? 1 : 0;
  const int end = rank_ == 0 ? size_ : 1;
  for (int to = first; to < end; ++to)
    check_mpi(MPI_Isend(&outgoing_, sizeof outgoing_, MPI_BYTE, to, kNoticeTag, comm_,
                        &send_requests_.emplace_back(MPI_REQUEST_NULL)),
              "MPI_Isend");
}

void StopNotices::finish(int sender_count, bool has_root_sent) {
  const int expected_count = rank_ == 0 ? sender_count : has_root_sent ? 1 : 0;
  while (received_count_ < expected_count) {
    if (receive_request_ == MPI_REQUEST_NULL) start_receive();
    wait_politely(receive_request_);
    ++received_count_;
  }
  if (receive_request_ != MPI_REQUEST_NULL) {
    check_mpi(MPI_Cancel(&receive_request_), "MPI_Cancel");
    wait_politely(receive_request_);
  }
  for (MPI_Request& request : send_requests_) wait_politely(request);
}

StopNotices* stop_notices() { return notices().get(); }

void watch_for_stop(const Communicator& ranks, std::optional<double> limit_seconds) {
  const Communicator::Impl& impl = ranks.impl();
  COLOSSUS_CHECK(!notices(), "watch_for_stop() is called once");
  notices() = std::make_unique<StopNotices>(impl.stop, impl.rank, impl.size, limit_seconds);
  struct sigaction action {};
  action.sa_handler = &note_signal;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGUSR1, SIGUSR2, SIGTERM}) ::sigaction(signal, &action, nullptr);
}

bool is_stop_requested() { return stop_notices() && stop_notices()->poll().has_value(); }

void throw_if_stop_requested() {
  if (is_stop_requested()) throw stop_error();
}

core::Error stop_error() {
  COLOSSUS_CHECK(is_stop_requested());
  return {core::Status::kStopped, stop_notices()->poll()->text()};
}

}  // namespace colossus::cluster
