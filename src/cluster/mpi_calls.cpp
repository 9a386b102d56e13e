#include "cluster/mpi_calls.hpp"

#include <sched.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <thread>

#include "cluster/stop_notices.hpp"

namespace colossus::cluster {
namespace {

constexpr int kYieldsBeforeSleep = 16;
constexpr std::chrono::microseconds kFirstSleep{50};
constexpr std::chrono::microseconds kLongestSleep{1000};

}  // namespace

void check_mpi(int code, const char* call) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  const std::string line =
      fmt::format("colossus: error: {} failed: {}: the connection between the ranks is broken\n", call,
                  std::string(text, static_cast<std::size_t>(length)));
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(nullptr);
  MPI_Abort(MPI_COMM_WORLD, static_cast<int>(core::Status::kIo));
}

void Backoff::pause() {
  if (yields_ < kYieldsBeforeSleep) {
    ++yields_;
    sched_yield();
    return;
  }
  const std::chrono::microseconds sleep = std::clamp(slept_ / 4, kFirstSleep, kLongestSleep);
  std::this_thread::sleep_for(sleep);
  slept_ += sleep;
}

void Backoff::reset() {
  slept_ = std::chrono::microseconds{0};
  yields_ = 0;
}

bool wait_politely(MPI_Request& request, std::optional<std::chrono::milliseconds> limit) {
  const auto start = std::chrono::steady_clock::now();
  Backoff backoff;
  for (;;) {
    int done = 0;
    check_mpi(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test");
    if (done != 0) return true;
    if (StopNotices* notices = stop_notices()) notices->poll();
    if (limit && std::chrono::steady_clock::now() - start > *limit) return false;
    backoff.pause();
  }
}

void wait_for_transfers(std::span<MPI_Request> requests) {
  Backoff backoff;
  std::vector<int> indices(requests.size());
  for (;;) {
    int completed = 0;
    check_mpi(MPI_Testsome(static_cast<int>(requests.size()), requests.data(), &completed, indices.data(),
                           MPI_STATUSES_IGNORE),
              "MPI_Testsome");
    if (completed == MPI_UNDEFINED) return;  // none is left
    if (completed > 0) backoff.reset();
    backoff.pause();
  }
}

void start_sends(std::span<const std::byte> bytes, int to, int tag, MPI_Comm comm, std::size_t piece_bytes,
                 std::vector<MPI_Request>& requests) {
  for (std::size_t offset = 0; offset < bytes.size(); offset += piece_bytes) {
    const std::size_t count = std::min(piece_bytes, bytes.size() - offset);
    check_mpi(MPI_Isend(bytes.data() + offset, static_cast<int>(count), MPI_BYTE, to, tag, comm,
                        &requests.emplace_back(MPI_REQUEST_NULL)),
              "MPI_Isend");
  }
}

void start_receives(std::span<std::byte> bytes, int from, int tag, MPI_Comm comm, std::size_t piece_bytes,
                    std::vector<MPI_Request>& requests) {
  for (std::size_t offset = 0; offset < bytes.size(); offset += piece_bytes) {
    const std::size_t count = std::min(piece_bytes, bytes.size() - offset);
    check_mpi(MPI_Irecv(bytes.data() + offset, static_cast<int>(count), MPI_BYTE, from, tag, comm,
                        &requests.emplace_back(MPI_REQUEST_NULL)),
              "MPI_Irecv");
  }
}

core::Bytes encode_error(const core::Error& error) {
  core::ByteWriter writer;
  writer.put(static_cast<std::int32_t>(error.status()));
  const std::string message = error.what();
  writer.put_array<char>(message);
  return writer.take();
}

core::Error decode_error(std::span<const std::byte> bytes) {
  core::ByteReader reader(bytes);
  const auto status = static_cast<core::Status>(reader.get<std::int32_t>());
  const std::vector<char> message = reader.get_array<char>(reader.remaining());
  return {status, std::string(message.begin(), message.end())};
}

}  // namespace colossus::cluster
