// A spool file of arbitrary bytes: reading any record of it gives bytes or an Error, never undefined
// behaviour; scanning it finds no record that cannot be read.
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>

#include "scratch/spool.hpp"

namespace {

using colossus::core::Bytes;
using colossus::core::Error;
using colossus::core::File;
using namespace colossus::scratch;

// One directory per process, in memory where that is possible.
class FuzzDirectory {
 public:
  FuzzDirectory() {
    const char* parent = std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : "/tmp";
    std::string name = std::string(parent) + "/fuzz-spool-XXXXXX";
    if (!::mkdtemp(name.data())) std::abort();
    path = name;
  }
  ~FuzzDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  std::filesystem::path path;
};

constexpr FileId kFile{1, 0, 1};

void read_record(const Location& location, const RecordRef& ref) {
  try {
    if (SpoolReader(location).read(ref).size() != ref.size) std::abort();
  } catch (const Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FuzzDirectory directory;
  const Location location{directory.path, 0};
  File::create(path_of(directory.path, kFile)).write_at(0, std::as_bytes(std::span(data, size)));
  // What a header at each of the first places would announce, and places where no record can be.
  constexpr std::size_t kMostPlaces = 64;
  for (std::size_t i = 0; i < kMostPlaces && i * 8 + kRecordHeaderBytes <= size; ++i) {
    RecordRef ref{kFile, 0, i * 8 + kRecordHeaderBytes, 0};
    std::memcpy(&ref.kind, data + i * 8 + 4, sizeof ref.kind);
    std::memcpy(&ref.size, data + i * 8 + 8, sizeof ref.size);
    read_record(location, ref);
  }
  constexpr std::uint64_t kHuge = std::numeric_limits<std::uint64_t>::max();
  for (const std::uint64_t offset :
       {std::uint64_t{0}, std::uint64_t{24}, std::uint64_t{25}, std::uint64_t{size}, kHuge, kHuge - 7})
    for (const std::uint64_t record_size :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{size}, kHuge, kHuge - 31})
      read_record(location, {kFile, 1, offset, record_size});
  scan_records(location, kFile, kHuge, [&](const RecordRef& ref, std::span<const std::byte> payload) {
    const Bytes read = SpoolReader(location).read(ref);
    if (!std::equal(read.begin(), read.end(), payload.begin(), payload.end())) std::abort();
  });
  return 0;
}
