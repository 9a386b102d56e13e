#include "cluster/detail/mpi_calls.hpp"

#include <sched.h>

#include <algorithm>
#include <string>
#include <thread>

namespace colossus::cluster::detail {
namespace {

constexpr int kYieldsBeforeSleep = 16;
constexpr std::chrono::microseconds kFirstSleep{50};

}  // namespace

void check_mpi(int code, const char* call) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(code, text, &length);
  core::fail(core::Status::kIo, "{} failed: {}: the connection between the ranks is broken", call,
             std::string(text, static_cast<std::size_t>(length)));
}

void Backoff::pause() {
  if (yields_ < kYieldsBeforeSleep) {
    ++yields_;
    sched_yield();
    return;
  }
  const std::chrono::microseconds sleep = std::min(std::max(slept_ / 4, kFirstSleep), longest_);
  std::this_thread::sleep_for(sleep);
  slept_ += sleep;
}

void Backoff::reset() {
  slept_ = std::chrono::microseconds{0};
  yields_ = 0;
}

bool wait_politely(std::span<MPI_Request> requests, std::chrono::microseconds longest_sleep,
                   std::optional<std::chrono::milliseconds> limit) {
  const auto start = std::chrono::steady_clock::now();
  Backoff backoff(longest_sleep);
  for (;;) {
    int done = 0;
    check_mpi(MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE),
              "MPI_Testall");
    if (done != 0) return true;
    if (limit && std::chrono::steady_clock::now() - start > *limit) return false;
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

}  // namespace colossus::cluster::detail
