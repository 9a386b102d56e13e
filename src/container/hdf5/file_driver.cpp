#include "container/hdf5/file_driver.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "container/hdf5/device_driver.hpp"

namespace colossus::container::hdf5 {
namespace {

using Driver = DeviceDriver<Device>;

// Runs an operation unless one has failed before; no exception may pass through HDF5's C code.
template <typename Operation>
void attempt(Device& device, Operation operation) {
  if (device.failure) return;
  try {
    operation();
  } catch (...) {
    device.failure = std::current_exception();
  }
}

// As HDF5's own driver for POSIX files, but for the pooling of small raw blocks: chunks follow each other.
herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

// The real size does not matter: the file starts empty, and is cut to the allocated end when it is closed.
haddr_t get_file_size(const H5FD_t*, H5FD_mem_t) { return 0; }

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, std::size_t size, void* buffer) {
  std::memset(buffer, 0, size);
  Device& device = Driver::device_of(file);
  attempt(device, [&] { device.file.read_some_at(offset, {static_cast<std::byte*>(buffer), size}); });
  return 0;
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t offset, std::size_t size,
                   const void* buffer) {
  Device& device = Driver::device_of(file);
  attempt(device, [&] { device.file.write_at(offset, {static_cast<const std::byte*>(buffer), size}); });
  if (type == H5FD_MEM_DRAW) {
    device.raw_write_offset = offset;
    device.raw_write_bytes = size;
  }
  return 0;
}

herr_t truncate_file(H5FD_t* file, hid_t, hbool_t) {
  Device& device = Driver::device_of(file);
  attempt(device, [&] {
    if (::ftruncate(device.file.descriptor(), static_cast<off_t>(device.end)) != 0)
      core::fail(core::write_status(errno), "{}: cannot set the size to {} bytes: {}",
                 device.file.path().string(), device.end, std::strerror(errno));
  });
  return 0;
}

H5FD_class_t make_class() {
  H5FD_class_t c = Driver::make_class("colossus");
  c.query = &query;
  c.get_eof = &get_file_size;
  c.read = &read_bytes;
  c.write = &write_bytes;
  c.truncate = &truncate_file;
  return c;
}

}  // namespace

Handle use_device(const Blame& blame, hid_t access, Device& device) {
  static const H5FD_class_t kClass = make_class();
  return Driver::use(blame, access, kClass, device);
}

}  // namespace colossus::container::hdf5
