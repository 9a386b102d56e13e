// Append-only files of checksummed records: what spools and journals are made of.
//
// A record is a header {magic, kind, size, checksum} of 24 bytes, the payload, and zeros up to a multiple of
// 8 bytes. The checksum covers payload, kind, size, file, offset and the build's key, so that no other record
// passes for the one that was asked for, and any changed byte is found. Numbers are little-endian. Records
// are read by the program version that wrote them, never by another one.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <type_traits>

#include "core/bytes.hpp"
#include "core/file.hpp"

namespace colossus::scratch {

// Where a build's scratch files lie, and its key: the fingerprint of its input and options, see Manifest.
struct Location {
  std::filesystem::path folder;
  std::uint64_t key = 0;
};

// One file. Each is created by one rank of one attempt, and written by nobody else.
struct FileId {
  std::uint16_t attempt = 0;  // from 1
  std::uint16_t rank = 0;
  std::uint16_t stream = 0;
  friend auto operator<=>(const FileId&, const FileId&) = default;
};

inline constexpr std::uint16_t kKeptStream = 0;  // see SpoolWriter
inline constexpr std::uint16_t kJournalStream = 0xffff;

// Where a record's payload lies. Small and trivially copyable, to be sent between ranks.
struct RecordRef {
  FileId file;
  std::uint16_t kind = 0;    // the user's; a record is read only as what it was written as
  std::uint64_t offset = 0;  // of the payload in the file, in bytes; a multiple of 8
  std::uint64_t size = 0;    // of the payload, in bytes
  friend auto operator<=>(const RecordRef&, const RecordRef&) = default;
};
static_assert(std::is_trivially_copyable_v<RecordRef> && sizeof(RecordRef) == 24);

// Consecutive records of a file, as a range of bytes that begins with a header.
struct Extent {
  FileId file;
  std::uint16_t padding = 0;
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  friend bool operator==(const Extent&, const Extent&) = default;
};
static_assert(std::is_trivially_copyable_v<Extent> && sizeof(Extent) == 24);

inline constexpr std::uint64_t kRecordHeaderBytes = 24;

// attempt-0001-rank-00003-stream-00007.spool, or attempt-0001-rank-00003.journal.
std::filesystem::path path_of(const std::filesystem::path& folder, const FileId& file);
// The inverse for the last part of such a path; nothing for any other name.
std::optional<FileId> file_of_name(const std::string& name);

// Appends to one file. Each append is written through to the operating system before it returns: a record can
// be read by any process of this host as soon as append() has returned.
class RecordFile {
 public:
  // Creates the file, which must not exist: Error(kCannotCreate).
  RecordFile(const Location& location, const FileId& file);

  // Appends one record whose payload consists of the parts, one after the other. Throws Error(kNoResources)
  // when the disk is full, Error(kIo) for other failures; the next append then overwrites what was written of
  // this one.
  RecordRef append(std::uint16_t kind, std::initializer_list<std::span<const std::byte>> parts);

  // Makes all records readable on other hosts too, if they open the file after this call; reports errors that
  // the file system delayed. Costs nothing on a local file system. Throws Error(kNoResources) or Error(kIo).
  void flush();

  const FileId& id() const { return id_; }
  std::uint64_t size() const { return end_; }  // in bytes

 private:
  FileId id_;
  std::uint64_t key_;
  std::uint64_t end_ = 0;
  core::File file_;
  core::Bytes buffer_;  // one record, or a part of a large one
};

// Opens a file of records for reading; Error(kIo) when there is none.
core::File open_records(const Location& location, const FileId& file);

// End of the record in the file, padding included; no file is so long when that exceeds 64 bits or `ref` is
// no place for a record.
std::uint64_t record_end(const RecordRef& ref);

// Checks header, payload and padding, the bytes from `ref.offset - kRecordHeaderBytes` to record_end(ref),
// against `ref`. Throws Error(kIo), with `path` in its message.
void check_record(const std::filesystem::path& path, std::uint64_t key, const RecordRef& ref,
                  std::span<const std::byte> header, std::span<const std::byte> payload_and_padding);

// Throws Error(kIo) unless the file, of `file_size` bytes, is long enough for the record.
void check_record_fits(const std::filesystem::path& path, const RecordRef& ref, std::uint64_t file_size);

// Visits all intact records below `limit`, in their order, whoever wrote them and in whatever state the file
// is: what is torn, damaged or foreign is stepped over. Returns the end of the last intact one; 0 when there
// is none, or no file. Throws Error(kIo) when the file cannot be read.
using VisitRecord = std::function<void(const RecordRef& ref, std::span<const std::byte> payload)>;
std::uint64_t scan_records(const Location& location, const FileId& file, std::uint64_t limit,
                           const VisitRecord& visit);

// Whether the extent consists of intact records without a gap. Reads it once, in pieces of a megabyte, and
// calls `poll`, which may throw, before each. A file that cannot be read counts as damaged.
bool is_intact(const Location& location, const Extent& extent, const std::function<void()>& poll);

}  // namespace colossus::scratch
