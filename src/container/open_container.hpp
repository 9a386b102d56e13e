// Private to this folder: a container while HDF5 has it open for reading.
#pragma once

#include <memory>
#include <mutex>

#include "container/hdf5/read_driver.hpp"
#include "container/hdf5/support.hpp"
#include "core/file.hpp"

namespace colossus::container {

// HDF5 is not thread-safe: held while anything of it is used for reading.
std::mutex& library_mutex();

// Stays where it is: HDF5 keeps a pointer to the device.
struct OpenContainer {
  // Throws Error(kBadData) unless the file's root, or exactly one group directly below it, is a container.
  explicit OpenContainer(std::shared_ptr<const core::File> opened);
  OpenContainer(const OpenContainer&) = delete;
  OpenContainer& operator=(const OpenContainer&) = delete;

  // To be called while an Error is handled: throws it again, or what kept the driver from reading, of which
  // HDF5 says only that it failed.
  [[noreturn]] void rethrow() const;

  std::shared_ptr<const core::File> bytes;
  hdf5::ReadDevice device;
  hdf5::Blame blame;
  hdf5::Handle driver;
  hdf5::Handle file;
  hdf5::Handle group;  // the container
};

}  // namespace colossus::container
