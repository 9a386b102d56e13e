// Spools: the geometry that a build keeps in scratch, written by one rank and read by all.
//
// Each rank writes one file per stream. A stream is what becomes superfluous at one time: the files of a
// stream that nobody needs any more can be deleted while the build goes on. Stream 0 is kept to the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <list>
#include <optional>
#include <span>
#include <vector>

#include "core/bytes.hpp"
#include "core/error.hpp"
#include "core/file.hpp"
#include "scratch/record.hpp"

namespace colossus::scratch {

// Appends to the spools of one rank; holds at most two files open. See RecordFile for what an append promises
// and throws; a file is created by the first append to it.
class SpoolWriter {
 public:
  SpoolWriter(Location location, std::uint16_t attempt, std::uint16_t rank);

  // Further records go to this stream, to which the rank has not written before. The first one is 1.
  void begin_stream(std::uint16_t stream);

  // Appends one record to the stream at hand. `kind` is below 2^16.
  RecordRef append(std::uint32_t kind, std::span<const std::byte> payload) { return append(kind, {payload}); }
  // The same for a payload that consists of several parts, one after the other.
  RecordRef append(std::uint32_t kind, std::initializer_list<std::span<const std::byte>> parts);
  // Appends one record to stream 0.
  RecordRef append_kept(std::uint32_t kind, std::span<const std::byte> payload);

  // See RecordFile::flush().
  void flush();

  // What has been appended between two calls of ends(), as at most two extents.
  struct Ends {
    std::uint64_t kept = 0;
    std::uint64_t stream = 0;
  };
  Ends ends() const;
  std::vector<Extent> extents_since(const Ends& before) const;

 private:
  RecordFile& open(std::optional<RecordFile>& file, std::uint16_t stream);

  Location location_;
  std::uint16_t attempt_;
  std::uint16_t rank_;
  std::uint16_t stream_ = 1;
  std::optional<RecordFile> kept_file_;
  std::optional<RecordFile> stream_file_;
};

// Reads records of all ranks and attempts. Keeps at most `most_open_files` files open.
class SpoolReader {
 public:
  explicit SpoolReader(Location location, std::size_t most_open_files = 64);

  // The payload. Throws Error(kIo) that names file, offset, expected and found when there is no such record,
  // or when it is torn or damaged. Allocates nothing for a record that the file is too short for.
  core::Bytes read(const RecordRef& ref);

  // Closes the files of these streams: the system frees the room of a deleted file when it is closed.
  void forget(std::uint16_t first_stream, std::uint16_t last_stream);

  // What `most_open_files` and forget() promise; for tests, nothing else asks.
  std::size_t open_file_count() const { return open_files_.size(); }

 private:
  struct OpenFile {
    FileId id;
    std::uint64_t size;  // when it was opened
    core::File file;
  };
  const OpenFile& open_file(const FileId& id, std::uint64_t least_size);

  Location location_;
  std::size_t most_open_files_;
  std::list<OpenFile> open_files_;  // the one used last is first
};

}  // namespace colossus::scratch
