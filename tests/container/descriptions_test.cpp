// What h5dump -A shows: every object and every field explains itself, in texts of fixed length.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <map>

#include "container/edits.hpp"
#include "container/fixtures.hpp"

namespace colossus::container {
namespace {

using test::Folder;
using test::make_sample;
using test::Sample;
using test::write_sample;

// Attributes that are texts, by name.
std::map<std::string, std::string> texts_of(hid_t object) {
  std::map<std::string, std::string> texts;
  const auto collect = [](hid_t id, const char* name, const H5A_info_t*, void* data) -> herr_t {
    const hid_t attribute = H5Aopen(id, name, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    if (H5Tget_class(type) == H5T_STRING) {
      EXPECT_EQ(H5Tis_variable_str(type), 0) << name;
      EXPECT_EQ(H5Tget_cset(type), H5T_CSET_UTF8) << name;
      std::string text(H5Tget_size(type), '\0');
      EXPECT_GE(H5Aread(attribute, type, text.data()), 0);
      (*static_cast<std::map<std::string, std::string>*>(data))[name] = text;
    }
    H5Tclose(type);
    H5Aclose(attribute);
    return 0;
  };
  hsize_t first = 0;
  EXPECT_GE(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, &first, collect, &texts), 0);
  return texts;
}

class Descriptions : public ::testing::Test {
 protected:
  Descriptions() {
    sample_.metadata.counts = {{"triangles", 10}, {"opposite", 0}, {"somebody's own", 1}};
    write_sample(sample_, folder_ / "a.h5");
    file_ = H5Fopen((folder_ / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  }
  ~Descriptions() override { H5Fclose(file_); }
  std::map<std::string, std::string> texts(const std::string& path) {
    const hid_t object = H5Oopen(file_, path.c_str(), H5P_DEFAULT);
    EXPECT_GE(object, 0) << path;
    auto result = texts_of(object);
    H5Oclose(object);
    return result;
  }

  Folder folder_;
  Sample sample_ = make_sample(20);
  hid_t file_ = -1;
};

TEST_F(Descriptions, TheRootSaysWhoMadeIt) {
  auto root = texts("/");
  EXPECT_EQ(root["producer"], "colossus");
  EXPECT_EQ(root["producer_version"], core::release_version());
  EXPECT_NE(root["documentation"].find("schemas/container.md"), std::string::npos);
  EXPECT_NE(root["units"].find("unit of the input"), std::string::npos);
  const Metadata metadata = ContainerReader(folder_ / "a.h5").metadata();
  EXPECT_EQ(metadata.producer, "colossus");
  EXPECT_EQ(metadata.producer_version, core::release_version());
}

TEST_F(Descriptions, EveryObjectHasTitleDescriptionAndUnits) {
  std::vector<std::string> paths = {"/",         "/nodes",  "/lattice", "/options", "/parameters",
                                    "/measures", "/inputs", "/counts",  "/levels",  "/chunks"};
  for (const NodeRow& row : sample_.rows)
    paths.push_back(fmt::format("/chunks/class_{}", row.capacity_class));
  for (const std::string& path : paths) {
    EXPECT_FALSE(texts(path)["title"].empty()) << path;
    EXPECT_FALSE(texts(path)["description"].empty()) << path;
    EXPECT_FALSE(texts(path)["units"].empty()) << path;
  }
}

TEST_F(Descriptions, EveryFieldOfATableIsExplained) {
  for (const char* name : {"nodes", "options", "parameters", "measures", "inputs", "counts"}) {
    const auto found = texts(std::string("/") + name);
    const hid_t dataset = H5Dopen2(file_, name, H5P_DEFAULT);
    const hid_t type = H5Dget_type(dataset);
    for (int i = 0; i < H5Tget_nmembers(type); ++i) {
      char* field = H5Tget_member_name(type, static_cast<unsigned>(i));
      EXPECT_EQ(found.count(std::string("field_") + field), 1u) << name << ": " << field;
      H5free_memory(field);
    }
    H5Tclose(type);
    H5Dclose(dataset);
  }
  EXPECT_NE(texts("/nodes")["field_error"].find("unit: that of the input"), std::string::npos);
  EXPECT_EQ(texts("/levels").count("field_level"), 1u);
}

TEST_F(Descriptions, NamesOfRowsAreExplainedWhereTheyAreKnown) {
  const auto counts = texts("/counts");
  EXPECT_EQ(counts.count("row_triangles"), 1u);
  EXPECT_EQ(counts.count("row_opposite"), 1u);
  EXPECT_EQ(counts.count("row_duplicate"), 0u) << "not in this file";
  EXPECT_EQ(counts.count("row_somebody's own"), 0u);
  EXPECT_EQ(texts("/measures").count("row_input_area"), 1u);
  EXPECT_EQ(texts("/parameters").count("row_sigma0"), 1u);
  EXPECT_EQ(texts("/options").count("row_leaf_triangles"), 1u);
}

TEST_F(Descriptions, ContainersFromBeforeDoNotSayWhoMadeThem) {
  H5Fclose(file_);
  test::edit_file(folder_ / "a.h5", [](hid_t file) {
    H5Adelete(file, "producer");
    H5Adelete(file, "producer_version");
  });
  const Metadata metadata = ContainerReader(folder_ / "a.h5").metadata();
  EXPECT_EQ(metadata.producer, "");
  EXPECT_EQ(metadata.producer_version, "");
  file_ = H5Fopen((folder_ / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
}

}  // namespace
}  // namespace colossus::container
