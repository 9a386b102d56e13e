#include "cluster/communicator.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "cluster/mpi_calls.hpp"

namespace colossus::cluster {
namespace {

constexpr int kTransferTag = 1;

MPI_Datatype mpi_type(std::int64_t) { return MPI_INT64_T; }
MPI_Datatype mpi_type(std::uint64_t) { return MPI_UINT64_T; }

template <typename T>
void all_reduce(const Communicator::Impl& impl, std::span<T> values, MPI_Op operation) {
  if (impl.size == 1) return;
  const std::size_t piece = std::max<std::size_t>(1, impl.piece_bytes / sizeof(T));
  for (std::size_t first = 0; first < values.size(); first += piece) {
    const std::size_t count = std::min(piece, values.size() - first);
    MPI_Request request = MPI_REQUEST_NULL;
    check_mpi(MPI_Iallreduce(MPI_IN_PLACE, values.data() + first, static_cast<int>(count), mpi_type(T{}),
                             operation, impl.collective, &request),
              "MPI_Iallreduce");
    wait_politely(request);
  }
}

// Doubles as integers of the same order, so that their minimum is one bit pattern whoever asks: MPI_MIN of
// -0.0 and 0.0, or of a NaN, depends on the order of the ranks.
std::int64_t order_key(double value) {
  const auto bits = std::bit_cast<std::int64_t>(value);
  return bits >= 0 ? bits : bits ^ std::numeric_limits<std::int64_t>::max();
}
double from_order_key(std::int64_t key) {
  return std::bit_cast<double>(key >= 0 ? key : key ^ std::numeric_limits<std::int64_t>::max());
}

void all_reduce_doubles(const Communicator::Impl& impl, std::span<double> values, MPI_Op operation) {
  std::vector<std::int64_t> keys(values.size());
  std::transform(values.begin(), values.end(), keys.begin(), order_key);
  all_reduce<std::int64_t>(impl, keys, operation);
  std::transform(keys.begin(), keys.end(), values.begin(), from_order_key);
}

std::vector<std::uint64_t> sizes_of_all(const Communicator::Impl& impl, std::uint64_t mine) {
  std::vector<std::uint64_t> sizes(static_cast<std::size_t>(impl.size));
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Iallgather(&mine, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, impl.collective, &request),
            "MPI_Iallgather");
  wait_politely(request);
  return sizes;
}

// Sends to_each[r] to each rank r and receives from_sizes[r] bytes from it; the sizes have been agreed on
// before. The bytes for this rank itself are copied.
std::vector<core::Bytes> transfer(const Communicator::Impl& impl,
                                  std::span<const std::span<const std::byte>> to_each,
                                  std::span<const std::uint64_t> from_sizes) {
  std::vector<core::Bytes> from_each(from_sizes.size());
  std::vector<MPI_Request> requests;
  // Each rank starts with its successor, so that not all begin with the same one.
  for (int step = 1; step < impl.size; ++step) {
    const int from = (impl.rank + impl.size - step) % impl.size;
    core::Bytes& bytes = from_each[static_cast<std::size_t>(from)];
    bytes.resize(from_sizes[static_cast<std::size_t>(from)]);
    start_receives(bytes, from, kTransferTag, impl.collective, impl.piece_bytes, requests);
  }
  for (int step = 1; step < impl.size; ++step) {
    const int to = (impl.rank + step) % impl.size;
    start_sends(to_each[static_cast<std::size_t>(to)], to, kTransferTag, impl.collective, impl.piece_bytes,
                requests);
  }
  const auto self = static_cast<std::size_t>(impl.rank);
  if (from_sizes[self] > 0) from_each[self].assign(to_each[self].begin(), to_each[self].end());
  wait_for_transfers(requests);
  return from_each;
}

}  // namespace

Communicator::Communicator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Communicator::~Communicator() = default;

int Communicator::rank() const { return impl_->rank; }
int Communicator::size() const { return impl_->size; }

void Communicator::barrier() const {
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Ibarrier(impl_->collective, &request), "MPI_Ibarrier");
  wait_politely(request);
}

void Communicator::broadcast(core::Bytes& bytes, int root) const {
  if (impl_->size == 1) return;
  std::uint64_t size = bytes.size();
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Ibcast(&size, 1, MPI_UINT64_T, root, impl_->collective, &request), "MPI_Ibcast");
  wait_politely(request);
  bytes.resize(size);
  for (std::size_t offset = 0; offset < bytes.size(); offset += impl_->piece_bytes) {
    const std::size_t count = std::min(impl_->piece_bytes, bytes.size() - offset);
    check_mpi(MPI_Ibcast(bytes.data() + offset, static_cast<int>(count), MPI_BYTE, root, impl_->collective,
                         &request),
              "MPI_Ibcast");
    wait_politely(request);
  }
}

std::vector<core::Bytes> Communicator::gather(std::span<const std::byte> mine) const {
  std::vector<std::uint64_t> sizes = sizes_of_all(*impl_, mine.size());
  if (rank() != 0) std::fill(sizes.begin(), sizes.end(), 0);
  std::vector<std::span<const std::byte>> to_each(sizes.size());
  to_each[0] = mine;
  std::vector<core::Bytes> all = transfer(*impl_, to_each, sizes);
  if (rank() != 0) all.clear();
  return all;
}

std::vector<core::Bytes> Communicator::all_gather(std::span<const std::byte> mine) const {
  const std::vector<std::uint64_t> sizes = sizes_of_all(*impl_, mine.size());
  const std::vector<std::span<const std::byte>> to_each(sizes.size(), mine);
  return transfer(*impl_, to_each, sizes);
}

std::vector<core::Bytes> Communicator::exchange(std::vector<core::Bytes> to_each) const {
  COLOSSUS_CHECK(to_each.size() == static_cast<std::size_t>(size()), "{} parts for {} ranks", to_each.size(),
                 size());
  std::vector<std::uint64_t> to_sizes(to_each.size());
  std::vector<std::uint64_t> from_sizes(to_each.size());
  std::transform(to_each.begin(), to_each.end(), to_sizes.begin(),
                 [](const core::Bytes& part) { return part.size(); });
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Ialltoall(to_sizes.data(), 1, MPI_UINT64_T, from_sizes.data(), 1, MPI_UINT64_T,
                          impl_->collective, &request),
            "MPI_Ialltoall");
  wait_politely(request);
  // The part for this rank itself may be most of all: it is moved, not copied.
  const auto self = static_cast<std::size_t>(rank());
  core::Bytes own = std::move(to_each[self]);
  from_sizes[self] = 0;
  const std::vector<std::span<const std::byte>> parts(to_each.begin(), to_each.end());
  std::vector<core::Bytes> from_each = transfer(*impl_, parts, from_sizes);
  from_each[self] = std::move(own);
  return from_each;
}

void Communicator::all_sum(std::span<std::int64_t> values) const { all_reduce(*impl_, values, MPI_SUM); }
void Communicator::all_sum(std::span<std::uint64_t> values) const { all_reduce(*impl_, values, MPI_SUM); }
void Communicator::all_min(std::span<std::int64_t> values) const { all_reduce(*impl_, values, MPI_MIN); }
void Communicator::all_min(std::span<std::uint64_t> values) const { all_reduce(*impl_, values, MPI_MIN); }
void Communicator::all_min(std::span<double> values) const { all_reduce_doubles(*impl_, values, MPI_MIN); }
void Communicator::all_max(std::span<std::int64_t> values) const { all_reduce(*impl_, values, MPI_MAX); }
void Communicator::all_max(std::span<std::uint64_t> values) const { all_reduce(*impl_, values, MPI_MAX); }
void Communicator::all_max(std::span<double> values) const { all_reduce_doubles(*impl_, values, MPI_MAX); }

std::vector<std::string> Communicator::host_names() const {
  char name[MPI_MAX_PROCESSOR_NAME] = "";
  int length = 0;
  check_mpi(MPI_Get_processor_name(name, &length), "MPI_Get_processor_name");
  const std::span<const char> mine(name, static_cast<std::size_t>(length));
  std::vector<std::string> names;
  for (const core::Bytes& bytes : all_gather(core::as_bytes(mine))) {
    std::string& text = names.emplace_back(bytes.size(), ' ');
    std::transform(bytes.begin(), bytes.end(), text.begin(),
                   [](std::byte b) { return static_cast<char>(b); });
  }
  return names;
}

void Communicator::agree(const std::optional<core::Error>& mine) const {
  const std::int64_t nobody = size();
  const std::int64_t speaker = min<std::int64_t>(mine ? rank() : nobody);
  if (speaker == nobody) return;
  core::Bytes bytes;
  if (speaker == rank()) bytes = encode_error(*mine);
  broadcast(bytes, static_cast<int>(speaker));
  const core::Error error = decode_error(bytes);
  throw AgreedError(error.status(), error.what());
}

void Communicator::attempt(const std::function<void()>& step) const {
  std::optional<core::Error> error;
  try {
    step();
  } catch (...) {
    error.emplace(core::error_of_current_exception());
  }
  agree(error);
}

void Communicator::set_piece_bytes(std::size_t piece_bytes) {
  COLOSSUS_CHECK(piece_bytes > 0 && piece_bytes < (std::size_t{1} << 30), "{} bytes", piece_bytes);
  impl_->piece_bytes = piece_bytes;
}

}  // namespace colossus::cluster
