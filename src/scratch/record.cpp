#include "scratch/record.hpp"

#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "core/hash.hpp"

namespace colossus::scratch {
namespace {

constexpr std::uint32_t kMagic = 0x4c4f5053;  // "SPOL"
constexpr std::uint64_t kAlignment = 8;

// Records up to this size are put together in memory and written by one call; larger ones part by part.
constexpr std::size_t kMostBufferedBytes = std::size_t{1} << 20;
constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

struct RecordHeader {
  std::uint32_t magic;
  std::uint32_t kind;
  std::uint64_t size;
  std::uint64_t checksum;
};
static_assert(sizeof(RecordHeader) == kRecordHeaderBytes);

std::uint64_t padding_of(std::uint64_t size) { return (kAlignment - size % kAlignment) % kAlignment; }

// All that tells one record from another, beside its payload.
std::uint64_t seed_of(std::uint64_t key, const RecordRef& ref) {
  const std::uint64_t who = std::uint64_t{ref.file.attempt} << 48 | std::uint64_t{ref.file.rank} << 32 |
                            std::uint64_t{ref.file.stream} << 16 | ref.kind;
  return core::mix64(core::mix64(core::mix64(key ^ core::mix64(who)) + ref.offset) + ref.size);
}

class Checksum {
 public:
  Checksum(std::uint64_t key, const RecordRef& ref) : state_(XXH3_createState()) {
    COLOSSUS_CHECK(state_ && XXH3_64bits_reset_withSeed(state_.get(), seed_of(key, ref)) == XXH_OK);
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

bool is_zero(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

// The record whose header is found at `offset`, should it be one that can lie there and end by `limit`.
struct FoundRecord {
  RecordRef ref;
  std::uint64_t checksum = 0;
};
std::optional<FoundRecord> find_record(const core::File& file, const FileId& id, std::uint64_t offset,
                                       std::uint64_t limit) {
  RecordHeader header{};
  if (offset + sizeof header > limit) return std::nullopt;
  if (file.read_some_at(offset, std::as_writable_bytes(std::span(&header, 1))) != sizeof header)
    return std::nullopt;
  if (header.magic != kMagic || header.kind > std::numeric_limits<std::uint16_t>::max()) return std::nullopt;
  const RecordRef ref{id, static_cast<std::uint16_t>(header.kind), offset + sizeof header, header.size};
  if (record_end(ref) > limit) return std::nullopt;
  return FoundRecord{ref, header.checksum};
}

// Checks payload and padding piece by piece.
bool is_intact(const core::File& file, std::uint64_t key, const FoundRecord& record, core::Bytes& piece,
               const std::function<void()>& poll) {
  Checksum checksum(key, record.ref);
  const std::uint64_t payload_end = record.ref.offset + record.ref.size;
  for (std::uint64_t at = record.ref.offset; at < payload_end;) {
    poll();
    piece.resize(std::min<std::uint64_t>(kPieceBytes, payload_end - at));
    if (file.read_some_at(at, piece) != piece.size()) return false;
    checksum.add(piece);
    at += piece.size();
  }
  piece.resize(padding_of(record.ref.size));
  return file.read_some_at(payload_end, piece) == piece.size() && is_zero(piece) &&
         checksum.value() == record.checksum;
}

}  // namespace

std::filesystem::path path_of(const std::filesystem::path& folder, const FileId& file) {
  const std::string start = fmt::format("attempt-{:04}-rank-{:05}", file.attempt, file.rank);
  if (file.stream == kJournalStream) return folder / (start + ".journal");
  return folder / fmt::format("{}-stream-{:05}.spool", start, file.stream);
}

std::optional<FileId> file_of_name(const std::string& name) {
  unsigned attempt = 0;
  unsigned rank = 0;
  unsigned stream = kJournalStream;
  if (std::sscanf(name.c_str(), "attempt-%u-rank-%u-stream-%u", &attempt, &rank, &stream) < 2)
    return std::nullopt;
  constexpr unsigned kMost = std::numeric_limits<std::uint16_t>::max();
  if (attempt > kMost || rank > kMost || stream > kMost) return std::nullopt;
  const FileId file{static_cast<std::uint16_t>(attempt), static_cast<std::uint16_t>(rank),
                    static_cast<std::uint16_t>(stream)};
  if (path_of({}, file) != name) return std::nullopt;
  return file;
}

RecordFile::RecordFile(const Location& location, const FileId& file)
    : id_(file), key_(location.key), file_(core::File::create(path_of(location.folder, file), true)) {}

RecordRef RecordFile::append(std::uint16_t kind, std::initializer_list<std::span<const std::byte>> parts) {
  RecordRef ref{id_, kind, end_ + kRecordHeaderBytes, 0};
  for (const auto& part : parts) ref.size += part.size();
  Checksum checksum(key_, ref);
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

void RecordFile::flush() {
  // Network file systems promise that what was written before a close() is seen by an open() after it. To
  // close a copy of the descriptor is enough, and unlike fsync() it does not wait for a local disk.
  const int copy = ::dup(file_.descriptor());
  if (copy >= 0 && ::close(copy) == 0) return;
  core::fail(core::write_status(errno), "{}: cannot flush: {}", file_.path().string(), std::strerror(errno));
}

core::File open_records(const Location& location, const FileId& file) {
  try {
    return core::File::open_for_reading(path_of(location.folder, file));
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

void check_record(const std::filesystem::path& path, std::uint64_t key, const RecordRef& ref,
                  std::span<const std::byte> header, std::span<const std::byte> payload_and_padding) {
  RecordHeader found{};
  COLOSSUS_CHECK(header.size() == sizeof found && payload_and_padding.size() == record_end(ref) - ref.offset);
  std::memcpy(&found, header.data(), sizeof found);
  if (found.magic != kMagic || found.kind != ref.kind || found.size != ref.size)
    fail_damaged(
        path, ref.offset,
        "expected the header (magic {:#x}, kind {}, {} bytes), found (magic {:#x}, kind {}, {} bytes)",
        kMagic, ref.kind, ref.size, found.magic, found.kind, found.size);
  Checksum checksum(key, ref);
  checksum.add(payload_and_padding.first(ref.size));
  if (checksum.value() != found.checksum)
    fail_damaged(path, ref.offset, "expected checksum {:016x}, found {:016x}", found.checksum,
                 checksum.value());
  if (!is_zero(payload_and_padding.subspan(ref.size)))
    fail_damaged(path, ref.offset, "expected zeros after its {} bytes, found others", ref.size);
}

std::uint64_t scan_records(const Location& location, const FileId& id, std::uint64_t limit,
                           const VisitRecord& visit) {
  if (!std::filesystem::exists(path_of(location.folder, id))) return 0;
  const core::File file = open_records(location, id);
  limit = std::min(limit, file.size());
  std::uint64_t end = 0;
  core::Bytes bytes;
  for (std::uint64_t at = 0; at + kRecordHeaderBytes <= limit;) {
    const std::optional<FoundRecord> found = find_record(file, id, at, limit);
    if (found && is_intact(file, location.key, *found, bytes, [] {})) {
      bytes.resize(found->ref.size);
      file.read_at(found->ref.offset, bytes);
      visit(found->ref, bytes);
      end = at = record_end(found->ref);
    } else {
      at += kAlignment;
    }
  }
  return end;
}

bool is_intact(const Location& location, const Extent& extent, const std::function<void()>& poll) {
  if (extent.begin >= extent.end) return extent.begin == extent.end;
  try {
    const core::File file = open_records(location, extent.file);
    if (extent.end > file.size()) return false;
    core::Bytes piece;
    for (std::uint64_t at = extent.begin; at < extent.end;) {
      poll();
      const std::optional<FoundRecord> found = find_record(file, extent.file, at, extent.end);
      if (!found || !is_intact(file, location.key, *found, piece, poll)) return false;
      at = record_end(found->ref);
    }
    return true;
  } catch (const core::Error& error) {
    if (error.status() == core::Status::kIo) return false;
    throw;
  }
}

}  // namespace colossus::scratch
