// Files that are no container, and containers whose parts contradict each other although every checksum is
// right.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstddef>
#include <functional>
#include <limits>

#include "container/edits.hpp"
#include "container/fixtures.hpp"
#include "core/file.hpp"

namespace colossus::container {
namespace {

using core::Status;
using test::catch_error;
using test::edit_file;
using test::edit_row;
using test::Folder;
using test::kBoundsAt;
using test::kCenterAt;
using test::kClassAt;
using test::kErrorAt;
using test::kIndexAt;
using test::kLevelAt;
using test::kMaskAt;
using test::kPayloadAt;
using test::kRowBytes;
using test::kStoredAt;
using test::make_sample;
using test::write_sample;

void expect_refused(const std::filesystem::path& path, const std::vector<std::string>& parts) {
  const auto caught = catch_error([&] { ContainerReader reader(path); });
  EXPECT_EQ(caught.status, Status::kBadData);
  for (const std::string& part : parts)
    EXPECT_TRUE(caught.says(part)) << caught.message << "\nlacks " << part;
}

class Foreign : public ::testing::Test {
 protected:
  void SetUp() override { write_sample(make_sample(100), path_); }
  Folder folder_;
  std::filesystem::path path_ = folder_ / "a.h5";
};

TEST_F(Foreign, AcceptsTheUntouchedFile) {
  edit_row(path_, 0, kLevelAt, std::uint32_t{0});
  EXPECT_EQ(ContainerReader(path_).rows().size(), 100u);
}

TEST_F(Foreign, RefusesWhatIsNoFileOrNoHdf5) {
  expect_refused(folder_ / "missing.h5", {"missing.h5", "No such file"});
  core::File::create(folder_ / "empty.h5").close();
  expect_refused(folder_ / "empty.h5", {"empty.h5", "cannot open as an HDF5 file"});
  core::File text = core::File::create(folder_ / "text.h5");
  text.write_at(0, core::Bytes(5000, std::byte{'x'}));
  text.close();
  expect_refused(folder_ / "text.h5", {"cannot open as an HDF5 file", "file signature not found"});
}

TEST_F(Foreign, RefusesAnHdf5FileOfSomebodyElse) {
  H5Fclose(H5Fcreate((folder_ / "b.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  expect_refused(folder_ / "b.h5", {"b.h5", "is an HDF5 file, but no Colossus container"});
}

TEST_F(Foreign, RefusesANewerMajorVersionAndReadsANewerMinorOne) {
  const auto set_version = [&](std::uint32_t major, std::uint32_t minor) {
    edit_file(path_, [&](hid_t file) {
      const std::uint32_t version[2] = {major, minor};
      const hid_t attribute = H5Aopen(file, "schema_version", H5P_DEFAULT);
      ASSERT_GE(H5Awrite(attribute, H5T_STD_U32LE, version), 0);
      H5Aclose(attribute);
    });
  };
  set_version(2, 0);
  expect_refused(path_, {"schema version 2.0", "expected 1.x", "newer Colossus"});
  set_version(1, 7);
  EXPECT_EQ(ContainerReader(path_).metadata().schema_minor, 7u);
}

// As programs wrote it before there were measures, and before there were parameters.
TEST_F(Foreign, ReadsEarlierSchemaVersions) {
  Metadata expected = make_sample(100).metadata;
  expected.measures.clear();
  expected.producer.clear();
  expected.producer_version.clear();
  for (const std::uint32_t minor : {1U, 0U}) {
    edit_file(path_, [&](hid_t file) {
      const std::uint32_t version[2] = {1, minor};
      const hid_t attribute = H5Aopen(file, "schema_version", H5P_DEFAULT);
      ASSERT_GE(H5Awrite(attribute, H5T_STD_U32LE, version), 0);
      H5Aclose(attribute);
      if (minor == 1) {
        ASSERT_GE(H5Ldelete(file, "measures", H5P_DEFAULT), 0);
        for (const char* name :
             {"producer", "producer_version", "documentation", "units", "title", "description"})
          ASSERT_GE(H5Adelete(file, name), 0);
      } else {
        ASSERT_GE(H5Ldelete(file, "parameters", H5P_DEFAULT), 0);
        expected.parameters.clear();
      }
    });
    expected.schema_minor = minor;
    EXPECT_EQ(ContainerReader(path_).metadata(), expected);
  }
}

// The writer reads what it wrote before it gives the file its name.
TEST_F(Foreign, RefusesAParameterThatIsNoNumber) {
  test::Sample sample = make_sample(3);
  sample.metadata.parameters[1].value = std::numeric_limits<double>::quiet_NaN();
  // The writer finds it when it reads back, and no input is to blame.
  const auto caught = catch_error([&] { write_sample(sample, path_); });
  EXPECT_EQ(caught.status, Status::kIo);
  EXPECT_TRUE(caught.says("/parameters: row 1: a parameter: expected a finite number, found nan"))
      << caught.message;
}

TEST_F(Foreign, RefusesMissingParts) {
  for (const std::string name : {"nodes", "options", "inputs", "counts", "lattice", "chunks"}) {
    write_sample(make_sample(100), path_);
    edit_file(path_, [&](hid_t file) {
      ASSERT_GE(H5Lmove(file, name.c_str(), file, "elsewhere", H5P_DEFAULT, H5P_DEFAULT), 0);
    });
    expect_refused(path_, {"/" + name, "found none"});
  }
  for (const std::string name : {"schema_version", "scheme", "attributes"}) {
    write_sample(make_sample(100), path_);
    edit_file(path_, [&](hid_t file) { ASSERT_GE(H5Adelete(file, name.c_str()), 0); });
    expect_refused(path_, {name, "found none"});
  }
}

TEST_F(Foreign, RefusesALinkInsteadOfADataset) {
  write_sample(make_sample(100), folder_ / "other.h5");
  edit_file(path_, [&](hid_t file) {
    ASSERT_GE(H5Ldelete(file, "nodes", H5P_DEFAULT), 0);
    ASSERT_GE(
        H5Lcreate_external((folder_ / "other.h5").c_str(), "/nodes", file, "nodes", H5P_DEFAULT, H5P_DEFAULT),
        0);
  });
  expect_refused(path_, {"/nodes", "expected a dataset"});
}

TEST_F(Foreign, RefusesOtherTypes) {
  const auto replace = [&](const std::string& name, hid_t type, bool is_chunked) {
    write_sample(make_sample(100), path_);
    edit_file(path_, [&](hid_t file) {
      ASSERT_GE(H5Ldelete(file, name.c_str(), H5P_DEFAULT), 0);
      const hsize_t extent = 100;
      const hid_t space = H5Screate_simple(1, &extent, nullptr);
      const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
      if (is_chunked) H5Pset_chunk(properties, 1, &extent);
      H5Dclose(H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
      H5Pclose(properties);
      H5Sclose(space);
    });
  };
  replace("nodes", H5T_STD_U32LE, false);
  expect_refused(path_, {"/nodes", "expected a compound type"});
  replace("nodes", H5T_STD_U32LE, true);
  expect_refused(path_, {"/nodes", "expected a compound type"});

  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, H5T_VARIABLE);
  const hid_t row = H5Tcreate(H5T_COMPOUND, sizeof(char*));
  H5Tinsert(row, "name", 0, text);
  replace("options", row, false);
  expect_refused(path_, {"/options", "field name", "fixed text"});
  H5Tclose(row);
  H5Tclose(text);
}

TEST_F(Foreign, RefusesRowsThatCannotBe) {
  struct Case {
    std::function<void()> edit;
    std::string expected;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Case cases[] = {
      {[&] { edit_row(path_, 5, kCenterAt, std::int32_t{-1}); }, "a centre within 0 and 1048576"},
      {[&] { edit_row(path_, 5, kCenterAt + 8, std::int32_t{0}); }, "ordered by level and centre"},
      {[&] { edit_row(path_, 5, kErrorAt, nan); }, "an error of 0 or more"},
      {[&] { edit_row(path_, 5, kErrorAt, -1.0); }, "an error of 0 or more"},
      {[&] { edit_row(path_, 5, kBoundsAt, nan); }, "finite bounds"},
      {[&] { edit_row(path_, 5, kBoundsAt, 1e9); }, "minimum before maximum"},
      {[&] { edit_row(path_, 5, kClassAt, std::uint32_t{70}); }, "chunk class"},
      {[&] { edit_row(path_, 5, kClassAt, ~std::uint32_t{0}); }, "chunk class"},
      {[&] { edit_row(path_, 5, kIndexAt, std::uint32_t{99}); }, "of its class"},
      {[&] { edit_row(path_, 5, kStoredAt, ~std::uint64_t{0}); }, "stored bytes, as the chunk index says"},
      {[&] { edit_row(path_, 5, kStoredAt, std::uint64_t{0}); }, "a chunk of at least one byte"},
      {[&] { edit_row(path_, 5, kPayloadAt, ~std::uint64_t{0}); }, "a payload of at most"},
      {[&] { edit_row(path_, 5, kStoredAt, ContainerReader(path_).rows()[5].stored_bytes + 1); },
       "stored bytes, as the chunk index says"},
  };
  for (const Case& c : cases) {
    write_sample(make_sample(100), path_);
    c.edit();
    expect_refused(path_, {"a.h5: /nodes: row 5", c.expected, "found"});
  }
}

TEST_F(Foreign, RefusesAChunkDatasetOfAnotherExtent) {
  const std::uint32_t capacity_class = ContainerReader(path_).rows()[0].capacity_class;
  const std::string name = fmt::format("chunks/class_{}", capacity_class);
  edit_file(path_, [&](hid_t file) {
    ASSERT_GE(H5Lmove(file, name.c_str(), file, "elsewhere", H5P_DEFAULT, H5P_DEFAULT), 0);
    const hsize_t extent = class_capacity(capacity_class);
    const hsize_t wrong = extent * 1000;
    const hid_t space = H5Screate_simple(1, &wrong, nullptr);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, 1, &extent);
    H5Dclose(H5Dcreate2(file, name.c_str(), H5T_STD_U8LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
    H5Pclose(properties);
    H5Sclose(space);
  });
  expect_refused(path_, {"/" + name, "found an extent"});
}

TEST_F(Foreign, SaysWhichTableIsDamaged) {
  const core::Bytes good = core::read_file(path_);
  const std::string text = "leaf_triangles8000";  // a row, not what describes it
  core::Bytes bad = good;
  const auto at = std::search(bad.begin(), bad.end(), std::as_bytes(std::span(text)).begin(),
                              std::as_bytes(std::span(text)).end());
  ASSERT_NE(at, bad.end());
  *at ^= std::byte{1};
  core::File file = core::File::create(path_);
  file.write_at(0, bad);
  file.close();
  expect_refused(path_, {"/options", "expected checksum", "the file is damaged"});
}

}  // namespace
}  // namespace colossus::container
