// RAII for HDF5's identifiers, its errors as core::Error, and the zstd filter.
#pragma once

#include <hdf5.h>

#include <string>
#include <utility>

#include "core/error.hpp"

namespace colossus::container::hdf5 {

// The registered id of the zstd filter; its only parameter is the level.
inline constexpr H5Z_filter_t kZstdFilter = 32015;

// Owns one identifier. close() reports what a destructor could not.
class Handle {
 public:
  using Closer = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Closer closer) : id_(id), closer_(closer) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), closer_(other.closer_) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      close();
      id_ = std::exchange(other.id_, H5I_INVALID_HID);
      closer_ = other.closer_;
    }
    return *this;
  }
  ~Handle() { close(); }

  hid_t get() const { return id_; }
  herr_t close() {
    const hid_t id = std::exchange(id_, H5I_INVALID_HID);
    return id >= 0 ? closer_(id) : 0;
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
  Closer closer_ = nullptr;
};

// Turns off HDF5's own printing of errors while it lives.
class QuietErrors {
 public:
  QuietErrors();
  ~QuietErrors();
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

// Whose fault a failing call is: the file in the message, and the status where the system's error number says
// nothing better (a full disk is kNoResources, any other failing write or read kIo).
struct Blame {
  std::string file;
  core::Status status = core::Status::kIo;
  std::string group = {};  // that the container lies in: empty for the file's root, else "/name"

  // "FILE: /nodes" for the container's object "/nodes", wherever the container lies in the file.
  std::string place(const std::string& object) const { return file + ": " + group + object; }

  // Throws Error: file, what, and the innermost text of HDF5's error stack.
  [[noreturn]] void fail(const std::string& what) const;
  // The identifier in a Handle, or fail(what) when it is negative.
  Handle own(hid_t id, Handle::Closer closer, const std::string& what) const;
  // fail(what) when the result of a call is negative.
  void check(long long result, const std::string& what) const {
    if (result < 0) fail(what);
  }
};

// Makes HDF5 know the zstd filter in this program. The name that a file stores for a filter is the one known
// when the file is written, so it must be ours, not that of a plugin that happens to be installed. Decodes
// only, and at most kMaxFilteredBytes.
inline constexpr std::size_t kMaxFilteredBytes = std::size_t{1} << 30;
void register_zstd_filter(const Blame& blame);

}  // namespace colossus::container::hdf5
