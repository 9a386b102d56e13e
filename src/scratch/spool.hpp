// Spools: append-only files of checksummed records, one file per rank in a scratch directory.
//
// A record is a header {magic, kind, size, checksum} of 24 bytes, the payload, and zeros up to a multiple of
// 8 bytes. The checksum covers payload, kind, size, rank and offset, so that no other record passes for the
// one that was asked for, and any changed byte is found. Numbers are little-endian. Spools are read by the
// build that wrote them, never by another version.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <list>
#include <span>
#include <type_traits>

#include "core/bytes.hpp"
#include "core/error.hpp"
#include "core/file.hpp"

namespace colossus::scratch {

// Where a record's payload lies. Small and trivially copyable, to be sent between ranks.
struct RecordRef {
  std::uint32_t rank = 0;    // whose spool
  std::uint32_t kind = 0;    // the user's; a record is read only as what it was written as
  std::uint64_t offset = 0;  // of the payload in the file, in bytes; a multiple of 8
  std::uint64_t size = 0;    // of the payload, in bytes
  friend bool operator==(const RecordRef&, const RecordRef&) = default;
};
static_assert(std::is_trivially_copyable_v<RecordRef>);

inline constexpr std::uint64_t kRecordHeaderBytes = 24;

// Appends to the spool of one rank. Each append is written through to the operating system before it returns:
// a record can be read by any process of this host as soon as append() has returned.
class SpoolWriter {
 public:
  // Creates the file, which must not exist: Error(kCannotCreate).
  SpoolWriter(const std::filesystem::path& directory, std::uint32_t rank);

  // Appends one record. Throws Error(kNoResources) when the disk is full, Error(kIo) for other failures; the
  // next append then overwrites what was written of this one.
  RecordRef append(std::uint32_t kind, std::span<const std::byte> payload) { return append(kind, {payload}); }
  // The same for a payload that consists of several parts, one after the other.
  RecordRef append(std::uint32_t kind, std::initializer_list<std::span<const std::byte>> parts);

  // Makes all records readable on other hosts too, if they open the file after this call; reports errors that
  // the file system delayed. Costs nothing on a local file system. Throws Error(kNoResources) or Error(kIo).
  void flush();

  std::uint32_t rank() const { return rank_; }
  std::uint64_t size() const { return end_; }  // of the file, in bytes

 private:
  std::uint32_t rank_;
  std::uint64_t end_ = 0;
  core::File file_;
  core::Bytes buffer_;  // one record, or a part of a large one
};

// Reads records from the spools of all ranks, its own too. Keeps at most `most_open_files` files open.
class SpoolReader {
 public:
  explicit SpoolReader(std::filesystem::path directory, std::size_t most_open_files = 64);

  // The payload. Throws Error(kIo) that names file, offset, expected and found when there is no such record,
  // or when it is torn or damaged. Allocates nothing for a record that the file is too short for.
  core::Bytes read(const RecordRef& ref);

  std::size_t open_file_count() const { return open_files_.size(); }

 private:
  struct OpenFile {
    std::uint32_t rank;
    std::uint64_t size;  // when it was opened
    core::File file;
  };
  const OpenFile& open_file(std::uint32_t rank, std::uint64_t least_size);

  std::filesystem::path directory_;
  std::size_t most_open_files_;
  std::list<OpenFile> open_files_;  // the one used last is first
};

// Opens a spool for reading; Error(kIo) when there is none.
core::File open_spool(const std::filesystem::path& directory, std::uint32_t rank);

// End of the record in the file, padding included; no file is so long when that exceeds 64 bits or `ref` is
// no place for a record.
std::uint64_t record_end(const RecordRef& ref);

// Checks header, payload and padding, the bytes from `ref.offset - kRecordHeaderBytes` to record_end(ref),
// against `ref`. Throws Error(kIo), with `path` in its message.
void check_record(const std::filesystem::path& path, const RecordRef& ref, std::span<const std::byte> header,
                  std::span<const std::byte> payload_and_padding);

// Throws Error(kIo) unless the file, of `file_size` bytes, is long enough for the record.
void check_record_fits(const std::filesystem::path& path, const RecordRef& ref, std::uint64_t file_size);

}  // namespace colossus::scratch
