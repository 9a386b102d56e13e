// Private to this folder: the datasets of the chunks, and where their index says that each chunk lies.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "container/chunk.hpp"
#include "container/hdf5/read_driver.hpp"
#include "container/node_table.hpp"
#include "container/schema.hpp"

namespace colossus::container {

// The layout of a class' dataset is checked when the index is opened. What is passed by reference must
// outlive it.
class ChunkIndex {
 public:
  // Throws Error(kBadData) unless /chunks has a dataset for each class that rows use, of as many chunks.
  ChunkIndex(const hdf5::Blame& blame, hid_t container, hdf5::ReadDevice& device,
             std::span<const NodeRow> rows);

  // Where the chunk of a row lies. Throws Error(kBadData) when the index does not say. Some microseconds.
  FramePlace find(std::size_t row);

  // Whether the dataset of a class is filtered by zstd alone, so that its chunks are frames.
  bool has_frames(std::uint32_t capacity_class) const { return has_frames_[capacity_class]; }

  // The payload of a row, as the dataset's filters decode its chunk. Throws Error(kBadData).
  core::Bytes read(std::size_t row) const;

 private:
  void open_class(hid_t group, std::uint32_t capacity_class, std::uint64_t chunk_count);
  std::string place_of(const NodeRow& row) const;

  const hdf5::Blame& blame_;
  hdf5::ReadDevice& device_;
  std::span<const NodeRow> rows_;
  std::array<hdf5::Handle, kCapacityClassCount> classes_;
  std::array<bool, kCapacityClassCount> has_frames_{};
  std::unique_ptr<std::byte[]> buffer_;  // never written, see find()
  std::uint64_t buffer_bytes_ = 0;
};

}  // namespace colossus::container
