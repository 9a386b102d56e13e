#include "container/hdf5/support.hpp"

#include <zstd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "core/file.hpp"

namespace colossus::container::hdf5 {
namespace {

// With H5E_WALK_UPWARD, entry 0 is where the error was found.
herr_t take_innermost(unsigned n, const H5E_error2_t* entry, void* text) {
  if (n == 0 && entry->desc != nullptr) *static_cast<std::string*>(text) = entry->desc;
  return 0;
}

// The number behind "errno = " in the texts of HDF5's file drivers; 0 when there is none.
int system_error(const std::string& text) {
  static constexpr char kMark[] = "errno = ";
  const std::size_t at = text.find(kMark);
  return at == std::string::npos ? 0 : std::atoi(text.c_str() + at + sizeof(kMark) - 1);
}

// HDF5 calls this for every chunk that it decodes; see H5Z_func_t. Returns the decoded size, 0 for an error.
std::size_t filter_zstd(unsigned flags, std::size_t, const unsigned*, std::size_t stored_bytes,
                        std::size_t* buffer_bytes, void** buffer) {
  if ((flags & H5Z_FLAG_REVERSE) == 0) return 0;
  const unsigned long long size = ZSTD_getFrameContentSize(*buffer, stored_bytes);
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size == 0 ||
      size > kMaxFilteredBytes)
    return 0;
  void* decoded = std::malloc(size);
  if (decoded == nullptr) return 0;
  if (ZSTD_decompress(decoded, size, *buffer, stored_bytes) != size) {
    std::free(decoded);
    return 0;
  }
  std::free(*buffer);
  *buffer = decoded;
  *buffer_bytes = size;
  return size;
}

}  // namespace

QuietErrors::QuietErrors() {
  // HDF5 1.10 forgets blocks of memory when it meets damaged metadata, and complains about them on stderr
  // when the program ends. Every handle here is closed by its owner, so nothing is left for HDF5 to do at
  // that time.
  static const bool is_without_exit_handler = H5dont_atexit() >= 0;
  static_cast<void>(is_without_exit_handler);
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietErrors::~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

void Blame::fail(const std::string& what) const {
  std::string text;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, &take_innermost, &text);
  H5Eclear2(H5E_DEFAULT);
  const int error = system_error(text);
  if (error == 0) core::fail(status, "{}: {}: {}", file, what, text.empty() ? "HDF5 gives no reason" : text);
  core::fail(core::write_status(error), "{}: {}: {}", file, what, std::strerror(error));
}

Handle Blame::own(hid_t id, Handle::Closer closer, const std::string& what) const {
  if (id < 0) fail(what);
  return Handle(id, closer);
}

void register_zstd_filter(const Blame& blame) {
  static const H5Z_class2_t kClass = {H5Z_CLASS_T_VERS, kZstdFilter, 1,       1,
                                      "zstd",           nullptr,     nullptr, &filter_zstd};
  blame.check(H5Zregister(&kClass), "cannot register the zstd filter");
}

}  // namespace colossus::container::hdf5
