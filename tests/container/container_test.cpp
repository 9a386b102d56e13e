#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ctime>
#include <fstream>
#include <limits>
#include <memory>

#include "container/fixtures.hpp"
#include "core/file.hpp"

namespace colossus::container {
namespace {

using core::Status;
using test::catch_error;
using test::Folder;
using test::make_sample;
using test::Sample;
using test::write_sample;

TEST(Container, ReadsBackWhatWasWritten) {
  const Folder folder;
  const Sample sample = make_sample(200);
  write_sample(sample, folder / "a.h5");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.h5.part"));
  const ContainerReader reader(folder / "a.h5");
  EXPECT_EQ(reader.metadata(), sample.metadata);
  ASSERT_EQ(reader.rows().size(), sample.rows.size());
  for (std::size_t i = 0; i < sample.rows.size(); ++i) {
    NodeRow row = reader.rows()[i];
    EXPECT_GT(row.offset, 0u);
    row.offset = 0;
    row.chunk_index = 0;
    EXPECT_EQ(row, sample.rows[i]) << i;
    const auto payload = reader.read_payload(i);
    ASSERT_TRUE(payload.ok()) << payload.defect().message;
    EXPECT_EQ(payload.value(), sample.payloads[i]) << i;
  }
}

TEST(Container, RecordedRangesHoldTheFramesInRowOrder) {
  const Folder folder;
  const Sample sample = make_sample(200);
  write_sample(sample, folder / "a.h5");
  const core::Bytes file = core::read_file(folder / "a.h5");
  const ContainerReader reader(folder / "a.h5");
  std::uint64_t end = 0;
  for (std::size_t i = 0; i < sample.rows.size(); ++i) {
    const NodeRow& row = reader.rows()[i];
    EXPECT_GE(row.offset, end);
    end = row.offset + row.stored_bytes;
    EXPECT_TRUE(std::equal(sample.chunks[i].frame.begin(), sample.chunks[i].frame.end(),
                           file.begin() + static_cast<std::ptrdiff_t>(row.offset)));
  }
}

TEST(Container, PutsTheNodeTableBeforeTheChunks) {
  const Folder folder;
  write_sample(make_sample(200), folder / "a.h5");
  const ContainerReader reader(folder / "a.h5");
  const hid_t file = H5Fopen((folder / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t nodes = H5Dopen2(file, "nodes", H5P_DEFAULT);
  EXPECT_LE(H5Dget_offset(nodes), 4096u);
  EXPECT_LT(H5Dget_offset(nodes), reader.rows().front().offset);
  H5Dclose(nodes);
  H5Fclose(file);
}

TEST(Container, HasTheSameBytesEveryTime) {
  const Folder folder;
  const Sample sample = make_sample(150);
  write_sample(sample, folder / "a.h5");
  write_sample(make_sample(3), folder / "other.h5");
  write_sample(sample, folder / "b_with_another_name.h5");
  EXPECT_EQ(core::read_file(folder / "a.h5"), core::read_file(folder / "b_with_another_name.h5"));
  EXPECT_NE(core::read_file(folder / "a.h5"), core::read_file(folder / "other.h5"));
}

TEST(Container, DoesNotDependOnTheTime) {
  const Folder folder;
  const Sample sample = make_sample(3);
  write_sample(sample, folder / "a.h5");
  const core::Bytes bytes = core::read_file(folder / "a.h5");
  // Object times are seconds since 1970 in four little-endian bytes; none near now may occur.
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  for (auto second = now - 10; second <= now + 1; ++second) {
    const auto stamp = static_cast<std::uint32_t>(second);
    const auto pattern = std::as_bytes(std::span(&stamp, 1));
    EXPECT_EQ(std::search(bytes.begin(), bytes.end(), pattern.begin(), pattern.end()), bytes.end());
  }
}

TEST(Container, HoldsOneNodeOrNone) {
  const Folder folder;
  for (const std::size_t count : {0, 1}) {
    const Sample sample = make_sample(count);
    write_sample(sample, folder / "a.h5");
    EXPECT_EQ(ContainerReader(folder / "a.h5").rows().size(), count);
  }
}

TEST(Container, HoldsEmptyListsAndNoColumns) {
  const Folder folder;
  Sample sample = make_sample(2);
  sample.metadata.options.clear();
  sample.metadata.parameters.clear();
  sample.metadata.inputs.clear();
  sample.metadata.counts.clear();
  sample.metadata.levels.clear();
  write_sample(sample, folder / "a.h5");
  EXPECT_EQ(ContainerReader(folder / "a.h5").metadata(), sample.metadata);
}

TEST(Container, HasNoTableOfParametersWithoutParameters) {
  const Folder folder;
  Sample sample = make_sample(2);
  for (const bool has_parameters : {true, false}) {
    if (!has_parameters) sample.metadata.parameters.clear();
    write_sample(sample, folder / "a.h5");
    const hid_t file = H5Fopen((folder / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    EXPECT_EQ(H5Lexists(file, "parameters", H5P_DEFAULT) > 0, has_parameters);
    H5Fclose(file);
  }
}

TEST(Container, ReadsBackAContainerOfBlocks) {
  const Folder folder;
  const Sample sample = test::make_blocks_sample();
  write_sample(sample, folder / "a.h5");
  const ContainerReader reader(folder / "a.h5");
  EXPECT_EQ(reader.metadata(), sample.metadata);
  ASSERT_EQ(reader.rows().size(), sample.rows.size());
  for (std::size_t i = 0; i < sample.rows.size(); ++i)
    EXPECT_EQ(reader.rows()[i].center, sample.rows[i].center);
}

TEST(Container, DecodesThroughHdf5sOwnFilterPipeline) {
  const Folder folder;
  const Sample sample = make_sample(40);
  write_sample(sample, folder / "a.h5");
  const ContainerReader reader(folder / "a.h5");
  const hid_t file = H5Fopen((folder / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  for (std::size_t i = 0; i < reader.rows().size(); ++i) {
    const NodeRow& row = reader.rows()[i];
    const hid_t dataset =
        H5Dopen2(file, fmt::format("/chunks/class_{}", row.capacity_class).c_str(), H5P_DEFAULT);
    const hid_t space = H5Dget_space(dataset);
    const hsize_t count = class_capacity(row.capacity_class);
    const hsize_t start = count * row.chunk_index;
    H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, nullptr, &count, nullptr);
    const hid_t memory = H5Screate_simple(1, &count, nullptr);
    core::Bytes content(count);
    ASSERT_GE(H5Dread(dataset, H5T_STD_U8LE, memory, space, H5P_DEFAULT, content.data()), 0) << i;
    content.resize(row.payload_bytes);
    EXPECT_EQ(content, sample.payloads[i]) << i;
    H5Sclose(memory);
    H5Sclose(space);
    H5Dclose(dataset);
  }
  H5Fclose(file);
}

TEST(Writer, RemovesThePartWhenNotCommitted) {
  const Folder folder;
  const Sample sample = make_sample(10);
  {
    ContainerWriter writer(folder / "a.h5");
    writer.add_nodes(sample.metadata, sample.rows);
    writer.append_chunk(sample.chunks[0].frame);
    EXPECT_TRUE(std::filesystem::exists(folder / "a.h5.part"));
  }
  EXPECT_TRUE(folder.is_empty());
}

TEST(Writer, KeepsTheOldContainerUntilTheNewOneIsComplete) {
  const Folder folder;
  write_sample(make_sample(3), folder / "a.h5");
  const core::Bytes before = core::read_file(folder / "a.h5");
  {
    ContainerWriter writer(folder / "a.h5");
    writer.add_nodes(make_sample(10).metadata, make_sample(10).rows);
  }
  EXPECT_EQ(core::read_file(folder / "a.h5"), before);
  write_sample(make_sample(10), folder / "a.h5");
  EXPECT_EQ(ContainerReader(folder / "a.h5").rows().size(), 10u);
}

TEST(Writer, RefusesAPlaceWhereNothingCanBeCreated) {
  const Folder folder;
  const auto missing = catch_error([&] { ContainerWriter(folder / "missing/a.h5"); });
  EXPECT_EQ(missing.status, Status::kCannotCreate);
  EXPECT_TRUE(missing.says("a.h5.part")) << missing.message;
  std::filesystem::create_directory(folder / "folder");
  EXPECT_EQ(catch_error([&] { ContainerWriter(folder / "folder"); }).status, Status::kCannotCreate);
}

TEST(Writer, RefusesAFrameThatIsNotTheRows) {
  const Folder folder;
  const Sample sample = make_sample(3);
  ContainerWriter writer(folder / "a.h5");
  writer.add_nodes(sample.metadata, sample.rows);
  const auto caught = catch_error([&] { writer.append_chunk(sample.chunks[1].frame); });
  EXPECT_EQ(caught.status, Status::kIo);
  EXPECT_TRUE(caught.says("node 0")) << caught.message;
}

// As after a build that was killed, whose rank 0 may still live.
TEST(Writer, NeverWritesToAnotherWritersPartNorRenamesNorRemovesIt) {
  const Folder folder;
  const Sample sample = make_sample(3);
  auto stale = std::make_unique<ContainerWriter>(folder / "a.h5");
  stale->add_nodes(sample.metadata, sample.rows);
  {
    ContainerWriter writer(folder / "a.h5");
    for (const auto& chunk : sample.chunks) stale->append_chunk(chunk.frame);
    const auto caught = catch_error([&] { stale->commit(); });
    EXPECT_EQ(caught.status, Status::kIo);
    EXPECT_TRUE(caught.says("a.h5.part")) << caught.message;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.h5"));
    stale.reset();
    writer.add_nodes(sample.metadata, sample.rows);
    for (const auto& chunk : sample.chunks) writer.append_chunk(chunk.frame);
    writer.commit();
  }
  EXPECT_EQ(ContainerReader(folder / "a.h5").rows().size(), 3u);
}

// A limit on the size of files makes writes fail at any place: in the tables, in a chunk, in HDF5's last
// flush.
TEST(Writer, SurvivesAFailureAtAnyByteAndLeavesNothing) {
  const Folder folder;
  const Sample sample = make_sample(20);
  write_sample(sample, folder / "a.h5");
  const std::uint64_t size = std::filesystem::file_size(folder / "a.h5");
  const core::Bytes good = core::read_file(folder / "a.h5");
  std::filesystem::remove(folder / "a.h5");
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  for (std::uint64_t bytes = 0; bytes < size; bytes += bytes < 8000 ? 97 : 4001) {
    const rlimit limit{bytes, old_limit.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    const auto caught = catch_error([&] { write_sample(sample, folder / "a.h5"); });
    setrlimit(RLIMIT_FSIZE, &old_limit);
    EXPECT_TRUE(caught.status == Status::kIo || caught.status == Status::kNoResources) << bytes;
    EXPECT_TRUE(caught.says("File too large")) << bytes << ": " << caught.message;
    EXPECT_TRUE(folder.is_empty()) << bytes;
  }
  std::signal(SIGXFSZ, old_handler);
  write_sample(sample, folder / "a.h5");
  EXPECT_EQ(core::read_file(folder / "a.h5"), good) << "failures leave no trace in HDF5";
}

// The least processor time of some attempts to open it, in seconds: other programs make it longer, never
// shorter.
double seconds_to_open(const std::filesystem::path& path, std::size_t nodes) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i) {
    const std::clock_t start = std::clock();
    const ContainerReader reader(path);
    const std::clock_t end = std::clock();
    EXPECT_EQ(reader.rows().size(), nodes);
    least = std::min(least, static_cast<double>(end - start) / CLOCKS_PER_SEC);
  }
  return least;
}

// HDF5 looks up a chunk by its number in time that grows with the number of chunks: asked for each of them,
// four times the nodes would take 16 times as long.
TEST(Reader, OpensInTimeThatGrowsAsTheNodesDo) {
  const Folder folder;
  const Sample few = make_sample(64);
  const auto write = [&](std::uint32_t nodes) {
    Sample sample = few;
    sample.rows.clear();
    sample.chunks.clear();
    for (std::uint32_t i = 0; i < nodes; ++i) {
      sample.rows.push_back(few.rows[i % 64]);
      sample.rows.back().level = 12;
      sample.rows.back().center = {static_cast<std::int32_t>(i), 0, 0};
      sample.chunks.push_back(few.chunks[i % 64]);
    }
    std::filesystem::path path = folder / fmt::format("{}.h5", nodes);
    write_sample(sample, path);
    return path;
  };
  const double one = seconds_to_open(write(5000), 5000);
  const double four = seconds_to_open(write(20000), 20000);
  EXPECT_LT(four, 8 * one);
}

}  // namespace
}  // namespace colossus::container
