#include "container/hdf5/read_driver.hpp"

#include <cstring>

#include "container/hdf5/device_driver.hpp"

namespace colossus::container::hdf5 {
namespace {

using Driver = DeviceDriver<ReadDevice>;

// As HDF5's own driver for POSIX files.
herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr)
    *flags = H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t get_file_size(const H5FD_t* file, H5FD_mem_t) { return Driver::device_of(file).bytes; }

// No exception may pass through HDF5's C code. Behind the end of the file are zeros, as HDF5 expects.
herr_t read_bytes(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t offset, std::size_t size, void* buffer) {
  ReadDevice& device = Driver::device_of(file);
  if (device.is_tracing && type == H5FD_MEM_DRAW) {
    device.raw_offset = offset;
    device.raw_bytes = size;
    return 0;
  }
  try {
    auto* bytes = static_cast<std::byte*>(buffer);
    const std::size_t got = offset < device.bytes ? device.file->read_some_at(offset, {bytes, size}) : 0;
    std::memset(bytes + got, 0, size - got);
    return 0;
  } catch (...) {
    if (!device.failure) device.failure = std::current_exception();
    return -1;
  }
}

// Nobody writes: the file is opened for reading.
herr_t write_bytes(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, std::size_t, const void*) { return -1; }

H5FD_class_t make_class() {
  H5FD_class_t c = Driver::make_class("colossus_read");
  c.query = &query;
  c.get_eof = &get_file_size;
  c.read = &read_bytes;
  c.write = &write_bytes;
  return c;
}

}  // namespace

Handle use_device(const Blame& blame, hid_t access, ReadDevice& device) {
  static const H5FD_class_t kClass = make_class();
  return Driver::use(blame, access, kClass, device);
}

}  // namespace colossus::container::hdf5
