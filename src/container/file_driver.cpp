#include "container/file_driver.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>

namespace colossus::container::hdf5 {
namespace {

// What HDF5 keeps in the property list, copied byte by byte.
struct DriverInfo {
  Device* device;
};

// HDF5 sees the first member only, as C programs derive types.
struct OpenFile {
  H5FD_t base;
  Device* device;
};

Device& device_of(H5FD_t* file) { return *reinterpret_cast<OpenFile*>(file)->device; }
const Device& device_of(const H5FD_t* file) { return *reinterpret_cast<const OpenFile*>(file)->device; }

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

H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
  const auto* info = static_cast<const DriverInfo*>(H5Pget_driver_info(access));
  if (info == nullptr) return nullptr;
  auto* file = new (std::nothrow) OpenFile{};
  if (file == nullptr) return nullptr;
  file->device = info->device;
  return &file->base;
}

herr_t close_file(H5FD_t* file) {
  delete reinterpret_cast<OpenFile*>(file);
  return 0;
}

// As HDF5's own driver for POSIX files, but for the pooling of small raw blocks: chunks follow each other.
herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t get_end(const H5FD_t* file, H5FD_mem_t) { return device_of(file).end; }

herr_t set_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  device_of(file).end = end;
  return 0;
}

// The real size does not matter: the file starts empty, and is cut to the allocated end when it is closed.
haddr_t get_file_size(const H5FD_t*, H5FD_mem_t) { return 0; }

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, std::size_t size, void* buffer) {
  std::memset(buffer, 0, size);
  Device& device = device_of(file);
  attempt(device, [&] { device.file.read_some_at(offset, {static_cast<std::byte*>(buffer), size}); });
  return 0;
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t offset, std::size_t size,
                   const void* buffer) {
  Device& device = device_of(file);
  attempt(device, [&] { device.file.write_at(offset, {static_cast<const std::byte*>(buffer), size}); });
  if (type == H5FD_MEM_DRAW) {
    device.raw_write_offset = offset;
    device.raw_write_bytes = size;
  }
  return 0;
}

herr_t truncate_file(H5FD_t* file, hid_t, hbool_t) {
  Device& device = device_of(file);
  attempt(device, [&] {
    if (::ftruncate(device.file.descriptor(), static_cast<off_t>(device.end)) != 0)
      core::fail(core::write_status(errno), "{}: cannot set the size to {} bytes: {}",
                 device.file.path().string(), device.end, std::strerror(errno));
  });
  return 0;
}

H5FD_class_t make_class() {
  H5FD_class_t c{};
  c.name = "colossus";
  c.maxaddr = (haddr_t{1} << 63) - 1;
  c.fc_degree = H5F_CLOSE_STRONG;
  c.fapl_size = sizeof(DriverInfo);
  c.open = &open_file;
  c.close = &close_file;
  c.query = &query;
  c.get_eoa = &get_end;
  c.set_eoa = &set_end;
  c.get_eof = &get_file_size;
  c.read = &read_bytes;
  c.write = &write_bytes;
  c.truncate = &truncate_file;
  // Free space of raw data and of metadata is kept apart, as in HDF5's own driver for POSIX files.
  const H5FD_mem_t types[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
  std::memcpy(c.fl_map, types, sizeof(types));
  return c;
}

}  // namespace

Handle use_device(const Blame& blame, hid_t access, Device& device) {
  static const H5FD_class_t kClass = make_class();
  Handle driver = blame.own(H5FDregister(&kClass), &H5FDunregister, "cannot register the file driver");
  const DriverInfo info{&device};
  blame.check(H5Pset_driver(access, driver.get(), &info), "cannot set the file driver");
  return driver;
}

}  // namespace colossus::container::hdf5
