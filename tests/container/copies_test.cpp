// Containers that other programs have copied: to other places within the file, into a group of another file,
// with other layouts and filters.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdlib>
#include <functional>

#include "container/edits.hpp"
#include "container/fixtures.hpp"
#include "core/file.hpp"
#include "core/hash.hpp"

namespace colossus::container {
namespace {

using core::Status;
using test::catch_error;
using test::edit_file;
using test::edit_row;
using test::Folder;
using test::make_sample;
using test::Sample;
using test::write_sample;

// As all codecs do it: a payload ends with the XXH3-64 of what precedes it.
Sample sample_with_checksums(std::size_t node_count) {
  Sample sample = make_sample(node_count);
  for (std::size_t i = 0; i < node_count; ++i) {
    core::ByteWriter payload;
    payload.put_bytes(sample.payloads[i]);
    payload.put(core::hash64(sample.payloads[i]));
    sample.payloads[i] = payload.take();
    sample.chunks[i] = pack_chunk(sample.payloads[i]);
    NodeRow& row = sample.rows[i];
    row.capacity_class = sample.chunks[i].capacity_class;
    row.stored_bytes = sample.chunks[i].frame.size();
    row.payload_bytes = sample.payloads[i].size();
    row.checksum = sample.chunks[i].checksum;
  }
  return sample;
}

void expect_same_content(const std::filesystem::path& path, const Sample& sample) {
  const ContainerReader reader(path);
  EXPECT_EQ(reader.metadata(), sample.metadata);
  ASSERT_EQ(reader.rows().size(), sample.rows.size());
  for (std::size_t i = 0; i < sample.rows.size(); ++i) {
    EXPECT_EQ(reader.rows()[i].center, sample.rows[i].center);
    const auto payload = reader.read_payload(i);
    ASSERT_TRUE(payload.ok()) << payload.defect().message;
    EXPECT_EQ(payload.value(), sample.payloads[i]) << i;
  }
}

class Copies : public ::testing::Test {
 protected:
  void SetUp() override { write_sample(sample_, path_); }
  // Runs a tool of hdf5-tools on the container; "{in}" and "{out}" are the files.
  void run(const std::string& tool, std::string arguments, bool has_plugin = false) {
    const auto put = [&](const std::string& mark, const std::filesystem::path& path) {
      for (auto at = arguments.find(mark); at != std::string::npos; at = arguments.find(mark))
        arguments.replace(at, mark.size(), "'" + path.string() + "'");
    };
    put("{in}", path_);
    put("{out}", copy_);
    const std::string plugins = has_plugin
                                    ? std::filesystem::path(COLOSSUS_ZSTD_PLUGIN).parent_path().string()
                                    : (folder_ / "none").string();
    const std::string command = fmt::format("HDF5_PLUGIN_PATH='{}' '{}' {} 2>'{}'", plugins, tool, arguments,
                                            (folder_ / "log").string());
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  void expect_refused(const std::vector<std::string>& parts) {
    const auto caught = catch_error([&] { ContainerReader reader(copy_); });
    EXPECT_EQ(caught.status, Status::kBadData);
    for (const std::string& part : parts)
      EXPECT_TRUE(caught.says(part)) << caught.message << "\nlacks " << part;
  }

  const Sample sample_ = sample_with_checksums(100);
  Folder folder_;
  std::filesystem::path path_ = folder_ / "a.h5";
  std::filesystem::path copy_ = folder_ / "copy.h5";
};

#define SKIP_WITHOUT(tool)       \
  if (std::string(tool).empty()) \
  GTEST_SKIP() << "install hdf5-tools: there was no " #tool " when this was built"

TEST_F(Copies, OffsetsHoldInWhatWasWritten) {
  const ContainerReader reader(path_);
  EXPECT_TRUE(reader.offsets_hold());
  EXPECT_GT(reader.table_offset(), 0u);
  EXPECT_LT(reader.table_offset(), reader.frame_offset(0));
  for (std::size_t i = 0; i < reader.rows().size(); ++i)
    EXPECT_EQ(reader.frame_offset(i), reader.rows()[i].offset);
}

TEST_F(Copies, SurviveH5repack) {
  SKIP_WITHOUT(COLOSSUS_H5REPACK);
  run(COLOSSUS_H5REPACK, "{in} {out}");
  expect_same_content(copy_, sample_);
  const ContainerReader reader(copy_);
  EXPECT_FALSE(reader.offsets_hold());
  EXPECT_GT(reader.table_offset(), 0u);
  const core::Bytes file = core::read_file(copy_);
  for (std::size_t i = 0; i < sample_.rows.size(); ++i)
    EXPECT_TRUE(std::equal(sample_.chunks[i].frame.begin(), sample_.chunks[i].frame.end(),
                           file.begin() + static_cast<std::ptrdiff_t>(reader.frame_offset(i))));
}

TEST_F(Copies, SurviveH5repackInEveryFileFormat) {
  SKIP_WITHOUT(COLOSSUS_H5REPACK);
  for (const char* options : {"-L", "--low=0", "-S PAGE", "-c 1 -d 0", "-a 4096 -t 1"}) {
    run(COLOSSUS_H5REPACK, std::string(options) + " {in} {out}");
    expect_same_content(copy_, sample_);
  }
}

TEST_F(Copies, SurviveH5repackWithOtherFiltersAndLayouts) {
  SKIP_WITHOUT(COLOSSUS_H5REPACK);
  for (const char* options :
       {"-f GZIP=6", "-f NONE", "-f nodes:SHUF -f nodes:GZIP=3", "-l nodes,options:CHUNK=10",
        "-l options,counts:COMPA", "-f chunks/class_0:UD=32015,0,1,19"}) {
    run(COLOSSUS_H5REPACK, std::string(options) + " {in} {out}", true);
    expect_same_content(copy_, sample_);
    EXPECT_FALSE(ContainerReader(copy_).offsets_hold()) << options;
  }
}

TEST_F(Copies, DamageOfRecodedChunksIsFound) {
  SKIP_WITHOUT(COLOSSUS_H5REPACK);
  run(COLOSSUS_H5REPACK, "-f NONE {in} {out}", true);
  const std::uint64_t offset = ContainerReader(copy_).frame_offset(5);
  core::Bytes bytes = core::read_file(copy_);
  bytes[offset + 2] ^= std::byte{1};
  core::File file = core::File::create(copy_);
  file.write_at(0, bytes);
  file.close();
  const ContainerReader reader(copy_);
  const auto payload = reader.read_payload(5);
  ASSERT_FALSE(payload.ok());
  EXPECT_NE(payload.defect().message.find("node 5"), std::string::npos) << payload.defect().message;
  EXPECT_TRUE(reader.read_payload(4).ok());
}

TEST_F(Copies, WhatH5repackDropsIsNamed) {
  SKIP_WITHOUT(COLOSSUS_H5REPACK);
  run(COLOSSUS_H5REPACK, "-f GZIP=6 {in} {out}");
  expect_refused({"/chunks/class_", "found none", "plugin for zstd"});
}

TEST_F(Copies, SurviveH5copyIntoAGroup) {
  SKIP_WITHOUT(COLOSSUS_H5COPY);
  run(COLOSSUS_H5COPY, "-i {in} -o {out} -s / -d /statue");
  expect_same_content(copy_, sample_);
  EXPECT_FALSE(ContainerReader(copy_).offsets_hold());
  // Messages name the place.
  edit_row(copy_, 5, test::kCenterAt, std::int32_t{-1}, "/statue/nodes");
  expect_refused({"/statue/nodes: row 5"});
}

TEST_F(Copies, SeveralContainersInAFileAreRefused) {
  SKIP_WITHOUT(COLOSSUS_H5COPY);
  for (const char* name : {"one", "two"})
    run(COLOSSUS_H5COPY, fmt::format("-i {{in}} -o {{out}} -s / -d /{}", name));
  expect_refused({"expected one container, found 2", "/one", "/two"});
}

TEST_F(Copies, WithoutTheRootsAttributesTheMessageSaysHowToCopy) {
  SKIP_WITHOUT(COLOSSUS_H5COPY);
  for (const char* name :
       {"nodes", "lattice", "options", "parameters", "measures", "inputs", "counts", "levels", "chunks"})
    run(COLOSSUS_H5COPY, fmt::format("-i {{in}} -o {{out}} -s /{} -d /{}", name, name));
  expect_refused({"attributes of its root group", "h5copy -s / -d /statue"});
}

// By HDF5's own means, so that this runs without the tools, too.
TEST_F(Copies, SurviveH5Ocopy) {
  const hid_t from = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t to = H5Fcreate(copy_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Gclose(H5Gcreate2(to, "empty", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  ASSERT_GE(H5Ocopy(from, "/", to, "statue", H5P_DEFAULT, H5P_DEFAULT), 0);
  H5Fclose(to);
  H5Fclose(from);
  expect_same_content(copy_, sample_);
}

TEST_F(Copies, AUserBlockMovesEverything) {
  const hid_t from = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
  ASSERT_GE(H5Pset_userblock(creation, 1024), 0);
  const hid_t to = H5Fcreate(copy_.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT);
  ASSERT_GE(H5Ocopy(from, "/", to, "statue", H5P_DEFAULT, H5P_DEFAULT), 0);
  H5Pclose(creation);
  H5Fclose(to);
  H5Fclose(from);
  expect_same_content(copy_, sample_);
}

// More nodes than are looked up one by one: whether offsets hold is decided by a sample.
TEST(ManyNodes, AreSampled) {
  const Folder folder;
  const Sample few = make_sample(8);
  Sample sample;
  sample.metadata = few.metadata;
  constexpr std::uint32_t kNodes = 70000;
  for (std::uint32_t i = 0; i < kNodes; ++i) {
    sample.rows.push_back(few.rows[3]);  // the smallest
    sample.rows.back().level = 12;
    sample.rows.back().center = {static_cast<std::int32_t>(i), 0, 0};
    sample.chunks.push_back(few.chunks[3]);
  }
  write_sample(sample, folder / "a.h5");
  EXPECT_TRUE(ContainerReader(folder / "a.h5").offsets_hold());
  const hid_t from = H5Fopen((folder / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t to = H5Fcreate((folder / "copy.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Ocopy(from, "/", to, "statue", H5P_DEFAULT, H5P_DEFAULT), 0);
  H5Fclose(to);
  H5Fclose(from);
  const ContainerReader copy(folder / "copy.h5");
  EXPECT_FALSE(copy.offsets_hold());
  for (const std::size_t i : {0U, 1U, kNodes / 2, kNodes - 1}) {
    const auto payload = copy.read_payload(i);
    ASSERT_TRUE(payload.ok()) << payload.defect().message;
    EXPECT_EQ(payload.value(), few.payloads[3]);
  }
}

// One row's offset is stale: whatever it says, the index is right.
TEST_F(Copies, AStaleOffsetIsReadByTheIndex) {
  for (const std::uint64_t offset : {ContainerReader(path_).rows()[4].offset, std::uint64_t{1} << 40,
                                     ~std::uint64_t{0}, std::uint64_t{0}}) {
    write_sample(sample_, path_);
    edit_row(path_, 5, test::kOffsetAt, offset);
    expect_same_content(path_, sample_);
    EXPECT_FALSE(ContainerReader(path_).offsets_hold());
    EXPECT_EQ(ContainerReader(path_).rows()[5].offset, offset) << "rows are as they are stored";
  }
}

// A frame that was written again lies at the end of the file, and the index says so.
TEST_F(Copies, AFrameThatWasMovedIsReadByTheIndex) {
  const NodeRow row = ContainerReader(path_).rows()[5];
  const auto write = [&](const core::Bytes& frame) {
    edit_file(path_, [&](hid_t file) {
      const std::string name = fmt::format("chunks/class_{}", row.capacity_class);
      const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
      const hsize_t start = class_capacity(row.capacity_class) * row.chunk_index;
      ASSERT_GE(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, &start, frame.size(), frame.data()), 0);
      H5Dclose(dataset);
    });
  };
  // A larger one first: HDF5 writes in place what fits, and forgets free space when it closes the file.
  const auto rewrite = [&](const core::Bytes& frame) {
    write(core::Bytes(frame.size() + 1));
    write(frame);
  };
  rewrite(sample_.chunks[5].frame);
  EXPECT_FALSE(ContainerReader(path_).offsets_hold());
  EXPECT_NE(ContainerReader(path_).frame_offset(5), row.offset);
  expect_same_content(path_, sample_);

  // Offset and index both wrong: that is damage.
  core::Bytes damaged = sample_.chunks[5].frame;
  damaged.back() ^= std::byte{1};
  rewrite(damaged);
  edit_row(path_, 5, test::kOffsetAt, ContainerReader(path_).rows()[4].offset);
  const auto payload = ContainerReader(path_).read_payload(5);
  ASSERT_FALSE(payload.ok());
  EXPECT_NE(payload.defect().message.find("node 5"), std::string::npos);
  EXPECT_NE(payload.defect().message.find("expected checksum"), std::string::npos)
      << payload.defect().message;
}

TEST_F(Copies, AChunkThatTheIndexLacksIsDamage) {
  const NodeRow row = ContainerReader(path_).rows()[5];
  edit_file(path_, [&](hid_t file) {
    const std::string name = fmt::format("chunks/class_{}", row.capacity_class);
    const hid_t old = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
    const hid_t properties = H5Dget_create_plist(old);
    const hid_t space = H5Dget_space(old);
    ASSERT_GE(H5Ldelete(file, name.c_str(), H5P_DEFAULT), 0);
    H5Dclose(H5Dcreate2(file, name.c_str(), H5T_STD_U8LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    H5Sclose(space);
    H5Pclose(properties);
    H5Dclose(old);
  });
  std::filesystem::rename(path_, copy_);
  expect_refused({"/chunks/class_", "row ", "found none in the chunk index"});
}

}  // namespace
}  // namespace colossus::container
