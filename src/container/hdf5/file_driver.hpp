// The file driver through which HDF5 writes a container.
//
// HDF5 1.10 does not survive a write that fails: objects that cannot be flushed cannot be closed, and the
// library crashes when the program ends. So HDF5 never learns of a failure: the driver keeps the first one
// for us, and from then on pretends to write. The file is thrown away in that case. The driver also sees
// where HDF5 puts each chunk, which HDF5 itself tells only by searching its index.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <exception>

#include "container/hdf5/support.hpp"
#include "core/file.hpp"

namespace colossus::container::hdf5 {

// One file being written. Outlives the HDF5 file.
struct Device {
  core::File file;
  std::exception_ptr failure;  // the first core::Error of a read, write or truncation
  std::uint64_t end = 0;       // of the addresses that HDF5 has allocated
  std::uint64_t raw_write_offset =
      0;  // place and size of the last write of raw data (not of HDF5's metadata)
  std::uint64_t raw_write_bytes = 0;

  // Throws what went wrong since the file was opened.
  void check() const {
    if (failure) std::rethrow_exception(failure);
  }
};

// Makes a file access property list use the driver on `device`. The driver lives as long as the returned
// handle and the files opened with it.
Handle use_device(const Blame& blame, hid_t access, Device& device);

}  // namespace colossus::container::hdf5
