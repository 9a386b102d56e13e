// The ranks of one run, and what they do together.
//
// "Collective" means: every rank calls it, in the same order as the other collective calls. No call spins
// while it waits for other ranks: ranks may share cores, so a waiting rank sleeps (50 microseconds at first,
// growing to one millisecond). Every message is far smaller than 2 GiB, whatever the size of the bytes. A
// failing MPI call ends all ranks with status kIo and MPI's message.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::cluster {

// An error that all ranks throw, with the same status and message: run_ranks() ends such a run in order.
class AgreedError : public core::Error {
 public:
  using core::Error::Error;
};

// Small enough that pieces which arrive show that bytes are moving, large enough that they are few.
inline constexpr std::size_t kDefaultPieceBytes = std::size_t{1} << 20;

class Communicator {
 public:
  struct Impl;  // the only place where MPI's types are seen: mpi_calls.hpp
  explicit Communicator(std::unique_ptr<Impl> impl);
  ~Communicator();
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  // Not collective.
  int rank() const;
  int size() const;
  bool is_root() const { return rank() == 0; }

  // Collective. Returns when all ranks have called it.
  void barrier() const;

  // Collective. Replaces `bytes` on every rank by those of `root`.
  void broadcast(core::Bytes& bytes, int root = 0) const;

  // Collective. Rank 0 gets the bytes of each rank, by rank; the others get an empty vector.
  std::vector<core::Bytes> gather(std::span<const std::byte> mine) const;

  // Collective. Every rank gets the bytes of each rank, by rank.
  std::vector<core::Bytes> all_gather(std::span<const std::byte> mine) const;

  // Collective. `to_each[r]` goes to rank r; the result holds at [r] what came from rank r. `to_each` has
  // size() elements, of any sizes. Memory: what leaves and what arrives are held at the same time.
  std::vector<core::Bytes> exchange(std::vector<core::Bytes> to_each) const;

  // Collective. Element by element over all ranks, in place; the spans have one size on all ranks. The result
  // does not depend on the order of the ranks: that is why doubles have no sum. Sums wrap around modulo 2^64.
  // Doubles are ordered as numbers, with -0.0 below 0.0; NaNs lie beyond the infinities on the side of their
  // sign.
  void all_sum(std::span<std::int64_t> values) const;
  void all_sum(std::span<std::uint64_t> values) const;
  void all_min(std::span<std::int64_t> values) const;
  void all_min(std::span<std::uint64_t> values) const;
  void all_min(std::span<double> values) const;
  void all_max(std::span<std::int64_t> values) const;
  void all_max(std::span<std::uint64_t> values) const;
  void all_max(std::span<double> values) const;

  // The same for one value of one of these types.
  template <typename T>
  T sum(T value) const {
    all_sum(std::span<T>(&value, 1));
    return value;
  }
  template <typename T>
  T min(T value) const {
    all_min(std::span<T>(&value, 1));
    return value;
  }
  template <typename T>
  T max(T value) const {
    all_max(std::span<T>(&value, 1));
    return value;
  }

  // Collective. The host of each rank, by rank.
  std::vector<std::string> host_names() const;

  // Collective. Returns if no rank has an error; else every rank throws an AgreedError with the status and
  // the message of the lowest rank that has one.
  void agree(const std::optional<core::Error>& mine) const;

  // Collective. Runs `step`, which may fail on some ranks only, and agrees on the outcome. `step` must not
  // contain collective calls that the other ranks would wait for if it failed. Exceptions other than Error
  // become one, see core::error_of_current_exception().
  void attempt(const std::function<void()>& step) const;

  // Not collective, but all ranks must set the same, below 1 GiB. Bytes travel in pieces of at most this
  // size; tests set less.
  void set_piece_bytes(std::size_t piece_bytes);

  Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

// Sends what rank 0 has to all ranks. Collective.
template <typename T>
void broadcast_values(const Communicator& ranks, std::vector<T>& values) {
  core::Bytes bytes;
  if (ranks.is_root()) {
    const auto view = core::as_bytes(values);
    bytes.assign(view.begin(), view.end());
  }
  ranks.broadcast(bytes);
  core::ByteReader reader(bytes);
  values = reader.get_array<T>(bytes.size() / sizeof(T));
}

template <typename T>
void broadcast_value(const Communicator& ranks, T& value) {
  std::vector<T> values{value};
  broadcast_values(ranks, values);
  value = values.at(0);
}

}  // namespace colossus::cluster
