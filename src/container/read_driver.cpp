#include "container/read_driver.hpp"

#include <cstring>
#include <new>

namespace colossus::container::hdf5 {
namespace {

// What HDF5 keeps in the property list, copied byte by byte.
struct DriverInfo {
  ReadDevice* device;
};

// HDF5 sees the first member only, as C programs derive types.
struct OpenFile {
  H5FD_t base;
  ReadDevice* device;
};

ReadDevice& device_of(H5FD_t* file) { return *reinterpret_cast<OpenFile*>(file)->device; }
const ReadDevice& device_of(const H5FD_t* file) { return *reinterpret_cast<const OpenFile*>(file)->device; }

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

// As HDF5's own driver for POSIX files.
herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr)
    *flags = H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t get_end(const H5FD_t* file, H5FD_mem_t) { return device_of(file).end; }

herr_t set_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  device_of(file).end = end;
  return 0;
}

haddr_t get_file_size(const H5FD_t* file, H5FD_mem_t) { return device_of(file).bytes; }

// No exception may pass through HDF5's C code. Behind the end of the file are zeros, as HDF5 expects.
herr_t read_bytes(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t offset, std::size_t size, void* buffer) {
  ReadDevice& device = device_of(file);
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
  H5FD_class_t c{};
  c.name = "colossus_read";
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
  const H5FD_mem_t types[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
  std::memcpy(c.fl_map, types, sizeof(types));
  return c;
}

}  // namespace

Handle use_device(const Blame& blame, hid_t access, ReadDevice& device) {
  static const H5FD_class_t kClass = make_class();
  Handle driver = blame.own(H5FDregister(&kClass), &H5FDunregister, "cannot register the file driver");
  const DriverInfo info{&device};
  blame.check(H5Pset_driver(access, driver.get(), &info), "cannot set the file driver");
  return driver;
}

}  // namespace colossus::container::hdf5
