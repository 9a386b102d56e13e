// Damaged containers: whatever is wrong, opening or reading says so, and nothing crashes.
#include <gtest/gtest.h>

#include <fstream>

#include "container/fixtures.hpp"

// HDF5 1.10 forgets a block of some hundred bytes for each damaged piece of metadata that it meets.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace colossus::container {
namespace {

using core::Status;
using test::catch_error;
using test::Folder;
using test::make_sample;
using test::Sample;
using test::write_sample;

// Flips bits of one byte of a file; twice the same flip restores it.
void flip(const std::filesystem::path& path, std::uint64_t at, char bits) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(at));
  const auto byte = static_cast<char>(file.get() ^ bits);
  file.seekp(static_cast<std::streamoff>(at));
  file.put(byte);
  ASSERT_TRUE(file.good()) << at;
}

// Opens the file and reads every payload. Returns what was found to be wrong; empty when nothing was.
std::string complaint(const std::filesystem::path& path) {
  std::string found;
  const auto caught = catch_error([&] {
    const ContainerReader reader(path);
    for (std::size_t i = 0; i < reader.rows().size() && found.empty(); ++i)
      if (const auto payload = reader.read_payload(i); !payload) found = payload.defect().message;
  });
  EXPECT_TRUE(caught.status == Status::kOk || caught.status == Status::kBadData) << caught.message;
  return found.empty() ? caught.message : found;
}

Sample small_sample() {
  Sample sample = make_sample(4);
  for (std::size_t i = 0; i < 4; ++i) {
    sample.payloads[i] = test::make_payload(60 + i, i);
    sample.chunks[i] = pack_chunk(sample.payloads[i]);
    sample.rows[i].capacity_class = 0;
    sample.rows[i].stored_bytes = sample.chunks[i].frame.size();
    sample.rows[i].payload_bytes = 60 + i;
    sample.rows[i].checksum = sample.chunks[i].checksum;
  }
  return sample;
}

TEST(Damage, EveryChangedByteOfAChunkIsDetectedAndNamed) {
  const Folder folder;
  const auto path = folder / "a.h5";
  write_sample(small_sample(), path);
  const std::vector<NodeRow> rows = ContainerReader(path).rows();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::uint64_t at = rows[i].offset; at < rows[i].offset + rows[i].stored_bytes; ++at) {
      flip(path, at, 1);
      const ContainerReader reader(path);
      const auto payload = reader.read_payload(i);
      ASSERT_FALSE(payload.ok()) << "byte " << at;
      EXPECT_EQ(payload.defect().offset, rows[i].offset);
      EXPECT_NE(payload.defect().message.find(fmt::format("node {} (level 0", i)), std::string::npos)
          << payload.defect().message;
      EXPECT_TRUE(reader.read_payload((i + 1) % rows.size()).ok()) << "the other nodes are whole";
      flip(path, at, 1);
    }
  }
}

// Bytes that nobody reads (gaps between HDF5's blocks, the chunk index, which our reader does not need) may
// change; then everything must read back as before.
TEST(Damage, EveryChangedByteIsDetectedOrHarmless) {
  const Folder folder;
  const auto path = folder / "a.h5";
  const Sample sample = small_sample();
  write_sample(sample, path);
  const std::vector<NodeRow> rows = ContainerReader(path).rows();
  const std::uint64_t size = std::filesystem::file_size(path);
  std::uint64_t harmless = 0;
  for (std::uint64_t at = 0; at < size; ++at) {
    flip(path, at, 0x10);
    if (complaint(path).empty()) {
      ++harmless;
      const ContainerReader reader(path);
      ASSERT_EQ(reader.metadata(), sample.metadata) << "byte " << at;
      ASSERT_EQ(reader.rows(), rows) << "byte " << at;
    }
    flip(path, at, 0x10);
  }
  std::printf("%llu of %llu bytes changed without harm\n", static_cast<unsigned long long>(harmless),
              static_cast<unsigned long long>(size));
  EXPECT_LT(harmless, size / 2);
}

TEST(Damage, TruncationAtEveryLengthIsRefused) {
  const Folder folder;
  const auto path = folder / "a.h5";
  write_sample(small_sample(), path);
  for (std::uint64_t size = std::filesystem::file_size(path); size-- > 0;) {
    std::filesystem::resize_file(path, size);
    const std::string found = complaint(path);
    ASSERT_NE(found, "") << size;
    EXPECT_NE(found.find("a.h5"), std::string::npos) << found;
  }
}

}  // namespace
}  // namespace colossus::container
