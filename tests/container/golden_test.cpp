// Containers that earlier programs have written, one per scheme and schema version:
// golden/<scheme>_<version>.h5, and beside each a text of two lines, what it holds.
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "container/descriptions.hpp"
#include "container/fixtures.hpp"
#include "core/hash.hpp"

namespace colossus::container {
namespace {

std::vector<std::filesystem::path> golden_containers() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(COLOSSUS_GOLDEN))
    if (entry.path().extension() == ".h5") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

// Rows, vertices, triangles, and a hash over the payloads, one after the other.
std::string content(const ContainerReader& reader) {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  core::ByteWriter payloads;
  for (std::size_t i = 0; i < reader.rows().size(); ++i) {
    vertices += reader.rows()[i].vertices;
    triangles += reader.rows()[i].triangles;
    const auto payload = reader.read_payload(i);
    EXPECT_TRUE(payload.ok()) << payload.defect().message;
    if (payload) payloads.put_bytes(payload.value());
  }
  return fmt::format("{} rows, {} vertices, {} triangles\npayloads {:016x}\n", reader.rows().size(), vertices,
                     triangles, core::hash64(payloads.bytes()));
}

std::string stated_content(std::filesystem::path path) {
  std::ifstream file(path.replace_extension(".txt"));
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Golden, ThereAreSomeOfEverySchema) {
  for (std::uint32_t minor = 1; minor <= kSchemaMinor; ++minor)
    for (const char* scheme : {"diamonds", "blocks"})
      EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(COLOSSUS_GOLDEN) /
                                          fmt::format("{}_{}_{}.h5", scheme, kSchemaMajor, minor)));
}

TEST(Golden, AllAreReadWithWhatTheyHeld) {
  for (const auto& path : golden_containers()) {
    const ContainerReader reader(path);
    EXPECT_TRUE(reader.offsets_hold()) << path;
    const Metadata& metadata = reader.metadata();
    EXPECT_EQ(path.stem(),
              fmt::format("{}_{}_{}", metadata.scheme, metadata.schema_major, metadata.schema_minor));
    EXPECT_EQ(content(reader), stated_content(path)) << path;
  }
}

// What programs from 1.2 on write is explained, name by name.
TEST(Golden, WhatTheyHoldIsDescribed) {
  for (const auto& path : golden_containers()) {
    const ContainerReader reader(path);
    const Metadata& metadata = reader.metadata();
    EXPECT_EQ(metadata.producer, metadata.schema_minor < 2 ? "" : "colossus") << path;
    EXPECT_EQ(metadata.producer_version.empty(), metadata.schema_minor < 2) << path;
    for (const auto& column : metadata.levels)
      EXPECT_FALSE(field_meaning("levels", column.name).empty()) << path << ": " << column.name;
    // What options of one scheme mean only that scheme knows: tests/program/tables_test.py looks at builds.
    const std::set<std::string> of_blocks{"block_size", "levels", "color_weight"};
    for (const auto& option : metadata.options)
      EXPECT_EQ(row_meaning("options", option.name).empty(), of_blocks.contains(option.name))
          << path << ": " << option.name;
    for (const auto& count : metadata.counts)
      EXPECT_FALSE(row_meaning("counts", count.name).empty()) << path << ": " << count.name;
    for (const auto& parameter : metadata.parameters)
      EXPECT_FALSE(row_meaning("parameters", parameter.name).empty()) << path << ": " << parameter.name;
    for (const auto& measure : metadata.measures)
      EXPECT_FALSE(row_meaning("measures", measure.name).empty()) << path << ": " << measure.name;
  }
}

}  // namespace
}  // namespace colossus::container
