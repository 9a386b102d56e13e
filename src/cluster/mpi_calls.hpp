// Private to this folder: MPI's types, checked calls, and waiting without spinning.
#pragma once

#include <mpi.h>

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "cluster/communicator.hpp"
#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::cluster {

struct Communicator::Impl {
  MPI_Comm collective = MPI_COMM_NULL;  // collective calls
  MPI_Comm farm = MPI_COMM_NULL;        // the task farm's messages
  MPI_Comm farewell = MPI_COMM_NULL;    // the ranks' last meeting, see run_ranks()
  MPI_Comm stop = MPI_COMM_NULL;        // notices of requests to stop
  int rank = 0;
  int size = 1;
  std::size_t piece_bytes = kDefaultPieceBytes;
};

// Unless `code` is MPI_SUCCESS, prints MPI's text and ends all ranks with status kIo. Not an exception: the
// buffers of messages under way would be freed while MPI still reads and writes them.
void check_mpi(int code, const char* call);

// Pauses between polls: a few yields, for answers that are almost there, then sleeps of at least 50
// microseconds that grow with the time already slept, up to a quarter of it and at most a millisecond, since
// waking up costs some 15 microseconds on a virtual machine.
class Backoff {
 public:
  void pause();
  void reset();

 private:
  std::chrono::microseconds slept_{0};
  int yields_ = 0;
};

// Waits for one request, and passes on requests to stop meanwhile. With a time limit, false when it is over.
bool wait_politely(MPI_Request& request, std::optional<std::chrono::milliseconds> limit = std::nullopt);

// Waits for sends and receives of many bytes. MPI moves a part of them in each poll, so a sleep between two
// polls would throttle them: it sleeps only while no request becomes complete.
void wait_for_transfers(std::span<MPI_Request> requests);

// Posts one send or receive per piece of at most piece_bytes; none for no bytes.
void start_sends(std::span<const std::byte> bytes, int to, int tag, MPI_Comm comm, std::size_t piece_bytes,
                 std::vector<MPI_Request>& requests);
void start_receives(std::span<std::byte> bytes, int from, int tag, MPI_Comm comm, std::size_t piece_bytes,
                    std::vector<MPI_Request>& requests);

// An error as bytes for other ranks; never empty.
core::Bytes encode_error(const core::Error& error);
core::Error decode_error(std::span<const std::byte> bytes);

}  // namespace colossus::cluster
