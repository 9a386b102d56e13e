// Writes a container: one rank, chunk by chunk, into PATH.part, which becomes PATH only when it is complete.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "container/schema.hpp"

namespace colossus::container {

// Order of calls: constructor, add_nodes once, append_chunk once per row, commit. The bytes of the file
// depend on the arguments only. Memory: the rows, and one frame. HDF5 is not thread-safe, so neither is this,
// not even two writers. Not collective.
//
// Every call throws Error: kNoResources when the device is full or a limit on file sizes is reached, kIo when
// writing fails otherwise. After an exception the writer can only be destroyed, which removes PATH.part.
class ContainerWriter {
 public:
  // Creates PATH.part, replacing one that a killed build left. Throws Error(kCannotCreate) when it cannot, or
  // when PATH is a folder. PATH itself is not touched before commit().
  explicit ContainerWriter(std::filesystem::path path);
  ~ContainerWriter();
  ContainerWriter(const ContainerWriter&) = delete;
  ContainerWriter& operator=(const ContainerWriter&) = delete;

  // Fixes the metadata and all rows, strictly ascending by (level, center); offset and chunk_index of the
  // rows are ignored. Makes room for the node table at the beginning of the file.
  void add_nodes(const Metadata& metadata, std::vector<NodeRow> rows);

  // Appends the frame of the next row. Throws Error(kIo) when its size or checksum is not the row's (it was
  // damaged on its way here), or when it cannot be read back from where HDF5 put it.
  void append_chunk(std::span<const std::byte> frame);

  // Writes the node table, closes the file, opens it once as a reader would, forces it to the device and
  // renames it.
  void commit();

  // The rows; offset and chunk_index are valid for those whose chunk has been appended.
  const std::vector<NodeRow>& rows() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace colossus::container
