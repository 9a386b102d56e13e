#include "scratch/spool.hpp"

#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "core/hash.hpp"
#include "scratch/directory.hpp"

namespace colossus::scratch {
namespace {

constexpr std::uint32_t kMagic = 0x4c4f5053;  // "SPOL"
constexpr std::uint64_t kAlignment = 8;

// Records up to this size are put together in memory and written by one call; larger ones part by part.
constexpr std::size_t kMostBufferedBytes = std::size_t{1} << 20;

struct RecordHeader {
  std::uint32_t magic;
  std::uint32_t kind;
  std::uint64_t size;
  std::uint64_t checksum;
};
static_assert(sizeof(RecordHeader) == kRecordHeaderBytes);

std::uint64_t padding_of(std::uint64_t size) { return (kAlignment - size % kAlignment) % kAlignment; }

// All that tells one record from another, beside its payload.
std::uint64_t seed_of(const RecordRef& ref) {
  const std::uint64_t who = (std::uint64_t{ref.rank} << 32) | ref.kind;
  return core::mix64(core::mix64(core::mix64(who) + ref.offset) + ref.size);
}

class Checksum {
 public:
  explicit Checksum(const RecordRef& ref) : state_(XXH3_createState()) {
    COLOSSUS_CHECK(state_ && XXH3_64bits_reset_withSeed(state_.get(), seed_of(ref)) == XXH_OK);
  }
  void add(std::span<const std::byte> bytes) { XXH3_64bits_update(state_.get(), bytes.data(), bytes.size()); }
  std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
};

void append_bytes(core::Bytes& buffer, std::span<const std::byte> bytes) {
  const std::size_t old_size = buffer.size();
  buffer.resize(old_size + bytes.size());
  if (!bytes.empty()) std::memcpy(buffer.data() + old_size, bytes.data(), bytes.size());
}

template <typename... Args>
[[noreturn]] void fail_damaged(const std::filesystem::path& path, std::uint64_t offset,
                               fmt::format_string<Args...> what, Args&&... args) {
  core::fail(core::Status::kIo, "{}: damaged scratch record at byte {}: {}: check the disk and run again",
             path.string(), offset, fmt::format(what, std::forward<Args>(args)...));
}

}  // namespace

SpoolWriter::SpoolWriter(const std::filesystem::path& directory, std::uint32_t rank)
    : rank_(rank), file_(core::File::create(ScratchDirectory::spool_path(directory, rank), true)) {}

RecordRef SpoolWriter::append(std::uint32_t kind, std::initializer_list<std::span<const std::byte>> parts) {
  RecordRef ref{rank_, kind, end_ + kRecordHeaderBytes, 0};
  for (const auto& part : parts) ref.size += part.size();
  Checksum checksum(ref);
  for (const auto& part : parts) checksum.add(part);
  const RecordHeader header{kMagic, kind, ref.size, checksum.value()};

  buffer_.clear();
  std::uint64_t written = end_;
  const auto write_buffer = [&] {
    file_.write_at(written, buffer_);
    written += buffer_.size();
    buffer_.clear();
  };
  append_bytes(buffer_, std::as_bytes(std::span(&header, 1)));
  for (const auto& part : parts) {
    if (buffer_.size() + part.size() <= kMostBufferedBytes) {
      append_bytes(buffer_, part);
      continue;
    }
    write_buffer();
    file_.write_at(written, part);
    written += part.size();
  }
  buffer_.resize(buffer_.size() + padding_of(ref.size));
  write_buffer();
  end_ = written;
  return ref;
}

void SpoolWriter::flush() {
  // Network file systems promise that what was written before a close() is seen by an open() after it. To
  // close a copy of the descriptor is enough, and unlike fsync() it does not wait for a local disk.
  const int copy = ::dup(file_.descriptor());
  if (copy >= 0 && ::close(copy) == 0) return;
  core::fail(core::write_status(errno), "{}: cannot flush: {}", file_.path().string(), std::strerror(errno));
}

SpoolReader::SpoolReader(std::filesystem::path directory, std::size_t most_open_files)
    : directory_(std::move(directory)), most_open_files_(std::max<std::size_t>(1, most_open_files)) {}

core::Bytes SpoolReader::read(const RecordRef& ref) {
  const std::uint64_t end = record_end(ref);
  const OpenFile& open = open_file(ref.rank, end);
  check_record_fits(open.file.path(), ref, open.size);
  std::array<std::byte, kRecordHeaderBytes> header{};
  core::Bytes bytes(end - ref.offset);
  // A file that was cut since it was opened leaves zeros here, which the check finds.
  open.file.read_some_at(ref.offset - kRecordHeaderBytes, header);
  open.file.read_some_at(ref.offset, bytes);
  check_record(open.file.path(), ref, header, bytes);
  bytes.resize(ref.size);
  return bytes;
}

const SpoolReader::OpenFile& SpoolReader::open_file(std::uint32_t rank, std::uint64_t least_size) {
  const auto found = std::find_if(open_files_.begin(), open_files_.end(),
                                  [&](const OpenFile& open) { return open.rank == rank; });
  if (found != open_files_.end()) {
    open_files_.splice(open_files_.begin(), open_files_, found);
    if (open_files_.front().size >= least_size) return open_files_.front();
    // The file has grown since. It is opened anew, since a network file system looks for the new size only
    // then.
    open_files_.pop_front();
  }
  core::File file = open_spool(directory_, rank);
  const std::uint64_t size = file.size();
  while (open_files_.size() >= most_open_files_) open_files_.pop_back();
  open_files_.push_front({rank, size, std::move(file)});
  return open_files_.front();
}

core::File open_spool(const std::filesystem::path& directory, std::uint32_t rank) {
  const std::filesystem::path path = ScratchDirectory::spool_path(directory, rank);
  try {
    return core::File::open_for_reading(path);
  } catch (const core::Error& error) {
    // For an input this would be the user's mistake; a scratch file was there before.
    throw core::Error(core::Status::kIo, fmt::format("scratch file {}", error.what()));
  }
}

std::uint64_t record_end(const RecordRef& ref) {
  constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();
  constexpr std::uint64_t kMost = std::uint64_t{1} << 62;
  if (ref.offset < kRecordHeaderBytes || ref.offset % kAlignment != 0) return kNever;
  if (ref.offset > kMost || ref.size > kMost) return kNever;
  return ref.offset + ref.size + padding_of(ref.size);
}

void check_record_fits(const std::filesystem::path& path, const RecordRef& ref, std::uint64_t file_size) {
  if (record_end(ref) <= file_size) return;
  fail_damaged(path, ref.offset, "expected {} bytes of kind {} there, found a file of {} bytes", ref.size,
               ref.kind, file_size);
}

void check_record(const std::filesystem::path& path, const RecordRef& ref, std::span<const std::byte> header,
                  std::span<const std::byte> payload_and_padding) {
  RecordHeader found{};
  COLOSSUS_CHECK(header.size() == sizeof found && payload_and_padding.size() == record_end(ref) - ref.offset);
  std::memcpy(&found, header.data(), sizeof found);
  if (found.magic != kMagic || found.kind != ref.kind || found.size != ref.size)
    fail_damaged(
        path, ref.offset,
        "expected the header (magic {:#x}, kind {}, {} bytes), found (magic {:#x}, kind {}, {} bytes)",
        kMagic, ref.kind, ref.size, found.magic, found.kind, found.size);
  Checksum checksum(ref);
  checksum.add(payload_and_padding.first(ref.size));
  if (checksum.value() != found.checksum)
    fail_damaged(path, ref.offset, "expected checksum {:016x}, found {:016x}", found.checksum,
                 checksum.value());
  const auto padding = payload_and_padding.subspan(ref.size);
  if (std::any_of(padding.begin(), padding.end(), [](std::byte b) { return b != std::byte{0}; }))
    fail_damaged(path, ref.offset, "expected zeros after its {} bytes, found others", ref.size);
}

}  // namespace colossus::scratch
