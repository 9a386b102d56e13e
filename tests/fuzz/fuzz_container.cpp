// Arbitrary bytes as a container, and as the rows of a node table. Only core::Error(kBadData) may come out.
//
// Mutated containers reach HDF5 1.10, which is not made for hostile bytes; its metadata carries checksums, so
// few mutations get past its door, and what lies behind it is hardly reached this way. Therefore the bytes
// are also taken for rows, which our own code checks before it relies on them.
//
// Seeds must be of the file format of HDF5 1.10 (h5repack -L): metadata of the old one has no checksums, and
// HDF5 1.10.8 reads beyond its buffers where it is mutated, in H5O__attr_exists and elsewhere.
#include <stdlib.h>  // mkstemp
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "container/node_table.hpp"
#include "container/reader.hpp"
#include "core/file.hpp"

namespace {

using namespace colossus;

// One file per process, rewritten for each input and gone at the end.
class Scratch {
 public:
  Scratch() : path_((std::filesystem::temp_directory_path() / "fuzz_container_XXXXXX").string()) {
    ::close(::mkstemp(path_.data()));
  }
  ~Scratch() { ::unlink(path_.c_str()); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void read_file(std::span<const std::byte> bytes) {
  static const Scratch scratch;
  core::File file = core::File::create(scratch.path());
  file.write_at(0, bytes);
  file.close();
  const container::ContainerReader reader(scratch.path());
  for (std::size_t i = 0; i < reader.rows().size(); ++i) {
    const auto payload = reader.read_payload(i);
    if (payload && payload.value().size() != reader.rows()[i].payload_bytes) std::abort();
  }
}

void read_rows(std::span<const std::byte> bytes) {
  container::Table table;
  table.place = "rows";
  table.fields = container::node_fields();
  table.row_bytes = container::pack_fields(table.fields);
  table.row_count = bytes.size() / table.row_bytes;
  table.rows.assign(bytes.begin(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(table.row_count * table.row_bytes));
  container::Metadata metadata;
  metadata.lattice = {{0, 0, 0}, 1, 20};
  const auto rows = container::decode_rows(table, metadata);
  if (container::encode_rows(rows) != table.rows) std::abort();
  static_cast<void>(container::chunk_counts(rows));
  static_cast<void>(container::place_defect(container::stated_places(rows), std::uint64_t{1} << 32));
}

template <typename Read>
void expect_bad_data_at_most(Read read) {
  try {
    read();
  } catch (const core::Error& error) {
    if (error.status() != core::Status::kBadData) std::abort();
  }
}

}  // namespace

// HDF5 1.10 forgets a block of some hundred bytes for each damaged piece of metadata that it meets.
// Its name is given. NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  expect_bad_data_at_most([&] { read_rows(bytes); });
  expect_bad_data_at_most([&] { read_file(bytes); });
  return 0;
}
