// The file driver through which HDF5 reads a container.
//
// It tells where a chunk lies without reading it. HDF5's own question for that, H5Dget_chunk_info_by_coord,
// walks through the index up to the chunk (HDF5 1.10: 2.7 s for 20,000 chunks in eight datasets), and leaves
// out the user block that a file may begin with. H5Dread_chunk finds the chunk at once, and the driver sees
// where it wants to read.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <exception>

#include "container/hdf5/support.hpp"
#include "core/file.hpp"

namespace colossus::container::hdf5 {

// One file being read. Outlives the HDF5 file.
struct ReadDevice {
  const core::File* file = nullptr;
  std::uint64_t bytes = 0;       // of the file
  std::uint64_t end = 0;         // of the addresses that HDF5 knows of
  std::exception_ptr failure;    // the first core::Error of a read
  bool is_tracing = false;       // raw data (not HDF5's metadata) is not read; only its place is noted:
  std::uint64_t raw_offset = 0;  // in the file
  std::uint64_t raw_bytes = 0;
};

// Makes a file access property list use the driver on `device`. The driver lives as long as the returned
// handle and the files opened with it.
Handle use_device(const Blame& blame, hid_t access, ReadDevice& device);

}  // namespace colossus::container::hdf5
