// Private to this folder: how ranks tell each other that they were asked to stop.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace colossus::cluster {

// Why to stop; sent between ranks.
struct StopNotice {
  std::int32_t signal = 0;  // 0: the time limit
  std::int32_t rank = 0;    // that received it
  std::string text() const;
};

// One rank's end. A notice goes to rank 0 at most once from each rank, and from rank 0 at most once to each.
class StopNotices {
 public:
  StopNotices(MPI_Comm comm, int rank, int size, std::optional<double> limit_seconds);

  // Looks for signals, the limit and notices, and passes on what it finds.
  const std::optional<StopNotice>& poll();

  // poll() finds nothing new from here on.
  void close() { is_closed_ = true; }
  bool has_sent() const { return has_sent_; }
  // Collective, after close(): receives what is still under way. `sender_count`: how many ranks but 0 have
  // sent a notice.
  void finish(int sender_count, bool has_root_sent);

 private:
  void start_receive();
  void receive();
  void send();

  MPI_Comm comm_;
  int rank_;
  int size_;
  std::optional<double> limit_seconds_;
  std::optional<StopNotice> notice_;
  bool has_sent_ = false;
  bool is_closed_ = false;
  int received_count_ = 0;
  StopNotice incoming_;
  StopNotice outgoing_;
  MPI_Request receive_request_ = MPI_REQUEST_NULL;
  std::vector<MPI_Request> send_requests_;
};

// Those of this process; nothing before watch_for_stop().
StopNotices* stop_notices();

}  // namespace colossus::cluster
