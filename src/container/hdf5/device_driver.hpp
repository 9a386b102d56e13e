// Private to this folder: what the file drivers for writing and for reading have in common.
#pragma once

#include <hdf5.h>

#include <cstring>
#include <new>

#include "container/hdf5/support.hpp"

namespace colossus::container::hdf5 {

// A driver whose files are `Device`s, of which each has a member `end`: that of the addresses that HDF5 knows
// of.
template <typename Device>
class DeviceDriver {
 public:
  static Device& device_of(const H5FD_t* file) { return *reinterpret_cast<const OpenFile*>(file)->device; }

  // All but query, get_eof, read and write, in which the drivers differ.
  static H5FD_class_t make_class(const char* name) {
    H5FD_class_t c{};
    c.name = name;
    c.maxaddr = (haddr_t{1} << 63) - 1;
    c.fc_degree = H5F_CLOSE_STRONG;
    c.fapl_size = sizeof(DriverInfo);
    c.open = &open_file;
    c.close = &close_file;
    c.get_eoa = &get_end;
    c.set_eoa = &set_end;
    // Free space of raw data and of metadata is kept apart, as in HDF5's own driver for POSIX files.
    const H5FD_mem_t types[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    std::memcpy(c.fl_map, types, sizeof(types));
    return c;
  }

  // The driver lives as long as the returned handle and the files opened with it.
  static Handle use(const Blame& blame, hid_t access, const H5FD_class_t& driver_class, Device& device) {
    Handle driver =
        blame.own(H5FDregister(&driver_class), &H5FDunregister, "cannot register the file driver");
    const DriverInfo info{&device};
    blame.check(H5Pset_driver(access, driver.get(), &info), "cannot set the file driver");
    return driver;
  }

 private:
  // What HDF5 keeps in the property list, copied byte by byte.
  struct DriverInfo {
    Device* device;
  };

  // HDF5 sees the first member only, as C programs derive types.
  struct OpenFile {
    H5FD_t base;
    Device* device;
  };

  static H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
    const auto* info = static_cast<const DriverInfo*>(H5Pget_driver_info(access));
    if (info == nullptr) return nullptr;
    auto* file = new (std::nothrow) OpenFile{};
    if (file == nullptr) return nullptr;
    file->device = info->device;
    return &file->base;
  }

  static herr_t close_file(H5FD_t* file) {
    delete reinterpret_cast<OpenFile*>(file);
    return 0;
  }

  static haddr_t get_end(const H5FD_t* file, H5FD_mem_t) { return device_of(file).end; }

  static herr_t set_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
    device_of(file).end = end;
    return 0;
  }
};

}  // namespace colossus::container::hdf5
