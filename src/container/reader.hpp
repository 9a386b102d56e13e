// Opens a container, which is not trusted: every fact that a read relies on is checked first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "container/schema.hpp"
#include "core/bytes.hpp"
#include "core/error.hpp"
#include "core/file.hpp"

namespace colossus::container {

// Metadata and node table of one container in memory; HDF5 is used while it opens, and for nothing after.
// Opening is not thread-safe (HDF5 is not), reading payloads is. Opens without locks, so read-only file
// systems will do. Cost: a few milliseconds for 20,000 nodes, and memory for their rows (about 140 bytes
// each). Not collective.
class ContainerReader {
 public:
  // Throws Error(kBadData) when the file is missing, truncated, damaged, no container, or of a newer schema.
  // The message names the file, the dataset and the row, what was expected and what was found.
  explicit ContainerReader(const std::filesystem::path& path);

  const Metadata& metadata() const { return metadata_; }
  const std::vector<NodeRow>& rows() const { return rows_; }
  std::uint64_t file_bytes() const { return file_bytes_; }
  const std::filesystem::path& path() const { return bytes_.path(); }

  // The payload of rows()[row]: its byte range is read, its checksum compared, its frame decoded. A Defect
  // names the node and what is wrong, its offset counts in the file. Throws Error(kIo) when the device fails.
  // Not collective.
  core::Result<core::Bytes> read_payload(std::size_t row) const;

 private:
  core::File bytes_;
  std::uint64_t file_bytes_ = 0;
  Metadata metadata_;
  std::vector<NodeRow> rows_;
};

}  // namespace colossus::container
