// Opens a container, which is not trusted: every fact that a read relies on is checked first.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "container/chunk.hpp"
#include "container/schema.hpp"
#include "core/bytes.hpp"
#include "core/error.hpp"
#include "core/file.hpp"

namespace colossus::container {

class ChunkIndex;

// Metadata and node table of one container in memory. HDF5 is used while it opens, and for nothing after,
// unless another program has encoded the chunks anew. Reading payloads is thread-safe, and so is opening, but
// not beside a writer. Opens without locks, so read-only file systems will do. Cost: some 15
// milliseconds for 20,000 nodes, most of them for the chunk index, and memory for their rows (about 140 bytes
// each). Not collective.
//
// Other programs may have copied the container (h5repack, h5copy, h5py): into a group directly below the root
// of another file, to other places than the rows' offsets say, tables into other layouts, and chunks with
// other filters. Such copies may have HDF5's old file format, without checksums of its metadata: HDF5 1.10
// may read beyond its buffers where somebody has damaged that on purpose.
class ContainerReader {
 public:
  // Throws Error(kBadData) when the file is missing, truncated, damaged, no container, or of a newer schema.
  // The message names the file, the dataset and the row, what was expected and what was found.
  explicit ContainerReader(const std::filesystem::path& path);
  // Moved, not copied: recoded_ looks at the rows.
  ContainerReader(ContainerReader&&) = default;
  ContainerReader& operator=(ContainerReader&&) = default;

  const Metadata& metadata() const { return metadata_; }
  // As they are stored, whether their offsets hold or not.
  const std::vector<NodeRow>& rows() const { return rows_; }
  std::uint64_t file_bytes() const { return file_bytes_; }
  const std::filesystem::path& path() const { return bytes_->path(); }

  // Whether the frames lie where the rows' offsets say. Where they do not, the chunk index says where they
  // are. Of containers with more than 65,536 nodes as many chunks, spread over all, are looked up.
  bool offsets_hold() const { return frames_.empty(); }
  // Where in the file the chunk of rows()[row] lies: the row's offset, where offsets hold.
  std::uint64_t frame_offset(std::size_t row) const {
    return frames_.empty() ? rows_[row].offset : frames_[row];
  }
  // Where in the file the rows of /nodes lie; 0 when there are none, or when they do not lie there as they
  // are (chunked or compact).
  std::uint64_t table_offset() const { return table_offset_; }

  // The payload of rows()[row]: its byte range is read, its checksum compared, its frame decoded. A Defect
  // names the node and what is wrong, its offset counts in the file. Throws Error(kIo) when the device fails.
  // Not collective.
  core::Result<core::Bytes> read_payload(std::size_t row) const;

 private:
  struct Recoded;  // chunks that are read through HDF5
  using Classes = std::bitset<kCapacityClassCount>;

  Classes find_frames(ChunkIndex& index, const std::string& place);

  std::shared_ptr<const core::File> bytes_;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t table_offset_ = 0;
  Metadata metadata_;
  std::vector<NodeRow> rows_;
  std::vector<std::uint64_t> frames_;  // where they are; empty where rows_ say it
  std::shared_ptr<const Recoded> recoded_;
};

}  // namespace colossus::container
