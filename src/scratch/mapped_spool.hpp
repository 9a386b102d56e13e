// Records of spools as memory: for random access to a part of a large record.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <utility>

#include "scratch/spool.hpp"

namespace colossus::scratch {

// Maps records read-only, each one by itself. The spans are valid as long as this object lives. Reads of them
// may wait for the disk, and end the program (SIGBUS) when the file is cut short meanwhile or the disk fails:
// use SpoolReader where that is not acceptable. Pages count as resident memory while they are in use, but can
// be dropped by the system.
class MappedSpool {
 public:
  explicit MappedSpool(Location location) : location_(std::move(location)) {}
  ~MappedSpool();
  MappedSpool(const MappedSpool&) = delete;
  MappedSpool& operator=(const MappedSpool&) = delete;

  // The payload, aligned to 8 bytes. Checked when it is mapped for the first time, which reads it once.
  // Throws like SpoolReader::read(); Error(kNoResources) when no more can be mapped (65,000 mappings by
  // default, on Linux).
  std::span<const std::byte> map(const RecordRef& ref);

  // The same as values of a type whose alignment is at most 8. Throws Error(kIo) unless the payload is a
  // whole number of them.
  template <typename T>
  std::span<const T> map_array(const RecordRef& ref) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 8);
    const std::span<const std::byte> bytes = map(ref);
    if (bytes.size() % sizeof(T) != 0) fail_size(ref, sizeof(T));
    return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
  }

 private:
  struct Mapping {
    void* address;
    std::size_t size;
    std::span<const std::byte> payload;
  };
  [[noreturn]] void fail_size(const RecordRef& ref, std::size_t value_size) const;

  Location location_;
  std::map<RecordRef, Mapping> mappings_;
};

}  // namespace colossus::scratch
