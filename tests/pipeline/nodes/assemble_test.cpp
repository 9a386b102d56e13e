// Containers of chunks that all ranks have stored, and what they say of the build.
#include "pipeline/nodes/assemble.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <random>

#include "container/reader.hpp"
#include "pipeline/facts/count_table.hpp"
#include "pipeline/facts/level_table.hpp"
#include "pipeline/nodes/node_builder.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::nodes {
namespace {

codec::Payload payload_of(std::uint64_t index) {
  std::mt19937_64 random(test_seed() + index);
  codec::Payload payload;
  payload.bytes.resize(500 + random() % 9000);
  for (std::byte& byte : payload.bytes) byte = static_cast<std::byte>(random() % 7);
  for (std::size_t i = 0; i < payload.cuts.size(); ++i) payload.cuts[i] = 20 * (i + 1);
  return payload;
}

// Nodes of levels 0 to 3, ordered; their chunks are made by whoever gets the task. Collective.
facts::FinishedNodes store_nodes(const run::Workspace& workspace, std::size_t count = 40) {
  facts::FinishedNodes finished;
  run_phase(
      workspace, "nodes", count,
      [](std::size_t i) {
        core::ByteWriter writer;
        writer.put(i);
        return writer.take();
      },
      [&](std::span<const std::byte> task) {
        const auto i = core::ByteReader(task).get<std::size_t>();
        facts::FinishedNode node;
        node.row.level = static_cast<std::uint32_t>(3 - i % 4);
        node.row.center = {static_cast<std::int32_t>(100 - i), 2, 3};
        node.row.tetra_mask = 1;
        node.row.flags = i % 4 == 0 ? container::kNodeIsLeaf : std::uint8_t{0};
        node.row.vertices = static_cast<std::uint32_t>(10 * i);
        node.row.triangles = static_cast<std::uint32_t>(20 * i);
        node.row.error = static_cast<double>(i);
        node.row.bounds = {0, 0, 0, 1, 1, 1};
        node.displacement = 0.5 * static_cast<double>(i);
        node.area = i % 4 == 0 ? 3.0 : 0.0;
        node.statistics.initial_triangles = 5 * i;
        store_chunk(workspace, codec::codecs()[i % codec::codecs().size()], payload_of(i), node);
        core::ByteWriter writer;
        writer.put(node);
        return writer.take();
      },
      [&](std::size_t, const core::Bytes& result) {
        finished.add(core::ByteReader(result).get<facts::FinishedNode>());
      });
  finished.sort();
  finished.lattice = {{10, 20, 30}, 0.25, 12};
  finished.position_bits = 14;
  finished.options = {{"of_the_scheme", "seven"}};
  finished.parameters = {{"sigma", 1.5}};
  return finished;
}

// Each count another number.
facts::Catalog made_up_catalog() {
  facts::Catalog catalog;
  catalog.files.push_back({"a.ply", 1234, "0123456789abcdef0123456789abcdef", false, true});
  catalog.files.push_back({"b\xff\\.obj", 5678, "fedcba9876543210fedcba9876543210", true, false});
  catalog.has_colors = true;
  catalog.bounds.low = {-1, -2, -3};
  catalog.bounds.high = {4, 5, 6};
  catalog.lattice.step = 0.5;
  catalog.area = 8.0;
  std::uint64_t next = 100;
  for (const facts::Count& count : facts::kCounts) catalog.counts.*count.member = next++;
  return catalog;
}

template <typename Named>
auto by_name(const std::vector<Named>& values) {
  std::map<std::string, decltype(Named::value)> map;
  for (const Named& named : values) map[named.name] = named.value;
  EXPECT_EQ(map.size(), values.size()) << "a name stands twice";
  return map;
}

TEST(Assemble, WritesEveryNodeOfEveryRank) {
  const CommonFolder folder;
  const TestBuild build(folder);
  const facts::FinishedNodes finished = store_nodes(build.workspace());
  if (!world().is_root()) return;
  const std::uint64_t bytes = assemble(build.workspace(), made_up_catalog(), "diamonds", finished);
  EXPECT_EQ(bytes, std::filesystem::file_size(folder / "out.h5"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out.h5.part"));
  const container::ContainerReader reader(folder / "out.h5");
  ASSERT_EQ(reader.rows().size(), finished.nodes.size());
  for (std::size_t i = 0; i < reader.rows().size(); ++i) {
    container::NodeRow row = finished.nodes[i].row;
    // The writer sets these two.
    row.chunk_index = reader.rows()[i].chunk_index;
    row.offset = reader.rows()[i].offset;
    EXPECT_EQ(reader.rows()[i], row);
    const core::Result<core::Bytes> payload = reader.read_payload(i);
    ASSERT_TRUE(payload.ok());
    EXPECT_EQ(payload.value(), payload_of(static_cast<std::uint64_t>(100 - row.center[0])).bytes);
  }
}

TEST(Assemble, SaysOfTheContainerWhatTheBuildKnows) {
  facts::BuildOptions options;
  options.leaf_triangles = 4321;
  options.tolerance = 0.125;
  const facts::Catalog catalog = made_up_catalog();
  for (const bool is_colored : {false, true}) {
    const CommonFolder folder;
    const TestBuild build(folder, options);
    const facts::FinishedNodes finished = store_nodes(build.workspace());
    if (!world().is_root()) continue;
    facts::Catalog input = catalog;
    input.has_colors = is_colored;
    assemble(build.workspace(), input, "blocks", finished);
    const container::ContainerReader reader(folder / "out.h5");
    const container::Metadata& metadata = reader.metadata();
    EXPECT_EQ(metadata.scheme, "blocks");
    EXPECT_EQ(metadata.lattice, finished.lattice);
    EXPECT_EQ(metadata.position_bits, 14);
    EXPECT_TRUE(metadata.has_normals);
    EXPECT_EQ(metadata.has_colors, is_colored);
    EXPECT_EQ(metadata.parameters, finished.parameters);
    EXPECT_EQ(metadata.inputs, (std::vector<container::InputInfo>{
                                   {"a.ply", 1234, "0123456789abcdef0123456789abcdef"},
                                   {R"(b\xff\\.obj)", 5678, "fedcba9876543210fedcba9876543210"}}));
    const auto texts = by_name(metadata.options);
    EXPECT_EQ(texts.at("leaf_triangles"), "4321");
    EXPECT_EQ(texts.at("position_bits"), "14") << "those that the build has chosen";
    EXPECT_EQ(texts.at("tolerance"), "0.125");
    EXPECT_EQ(texts.at("of_the_scheme"), "seven");
    EXPECT_EQ(texts.count("lenient"), 0U) << "it was not given";
    EXPECT_EQ(texts.count("scratch"), 0U) << "it shapes no bytes";
  }
}

TEST(Assemble, StoresCountsAsTheirTableSays) {
  for (const bool is_zero : {false, true}) {
    const CommonFolder folder;
    const TestBuild build(folder);
    const facts::FinishedNodes finished = store_nodes(build.workspace(), 4);
    if (!world().is_root()) continue;
    facts::Catalog catalog = made_up_catalog();
    if (is_zero) catalog.counts = {};
    assemble(build.workspace(), catalog, "diamonds", finished);
    std::vector<container::NamedCount> expected;
    for (const facts::Count& count : facts::kCounts)
      if (count.stored == facts::Stored::kAlways ||
          (count.stored == facts::Stored::kUnlessDefault && !is_zero))
        expected.push_back({count.name, catalog.counts.*count.member});
    EXPECT_EQ(container::ContainerReader(folder / "out.h5").metadata().counts, expected);
  }
}

TEST(Assemble, StoresAreasBoundsAndLevels) {
  const CommonFolder folder;
  const TestBuild build(folder);
  const facts::FinishedNodes finished = store_nodes(build.workspace());
  if (!world().is_root()) return;
  assemble(build.workspace(), made_up_catalog(), "diamonds", finished);
  const container::ContainerReader reader(folder / "out.h5");
  // 8 square units of 0.5 on the container's lattice of 0.25; ten leaves.
  EXPECT_EQ(by_name(reader.metadata().measures), (std::map<std::string, double>{{"input_area", 32.0},
                                                                                {"finest_area", 30.0},
                                                                                {"min_x", -1},
                                                                                {"min_y", -2},
                                                                                {"min_z", -3},
                                                                                {"max_x", 4},
                                                                                {"max_y", 5},
                                                                                {"max_z", 6}}));
  // Told from the rows, and not from the statistics that were added up.
  std::map<std::string, std::vector<double>> expected;
  for (const char* name : {"level", "nodes", "leaves", "vertices", "triangles", "payload_bytes",
                           "stored_bytes", "error", "quantization_error", "initial_triangles"})
    expected[name].resize(4);
  for (std::size_t level = 0; level < 4; ++level) expected["level"][level] = static_cast<double>(level);
  for (const container::NodeRow& row : reader.rows()) {
    const auto add = [&](const char* name, double value) { expected[name][row.level] += value; };
    add("nodes", 1);
    add("leaves", (row.flags & container::kNodeIsLeaf) != 0 ? 1 : 0);
    add("vertices", row.vertices);
    add("triangles", row.triangles);
    add("payload_bytes", static_cast<double>(row.payload_bytes));
    add("stored_bytes", static_cast<double>(row.stored_bytes));
    add("initial_triangles", 5.0 * (100 - row.center[0]));
    for (const auto& [name, share] : {std::pair{"error", 1.0}, {"quantization_error", 0.5}})
      expected[name][row.level] = std::max(expected[name][row.level], share * row.error);
  }
  std::size_t columns = 1;
  facts::for_each_level_field(
      [&](const facts::LevelField& field, auto) { columns += field.column != nullptr ? 1 : 0; });
  EXPECT_EQ(reader.metadata().levels.size(), columns);
  for (const container::LevelColumn& column : reader.metadata().levels) {
    const auto found = expected.find(column.name);
    if (found == expected.end()) continue;
    const auto values =
        std::visit([](const auto& v) { return std::vector<double>(v.begin(), v.end()); }, column.values);
    EXPECT_EQ(values, found->second) << column.name;
    expected.erase(found);
  }
  EXPECT_TRUE(expected.empty()) << expected.begin()->first << " is not stored";
}

// Nothing stands where the container should be.
TEST(Assemble, RefusesChunksThatAreDamagedOrOfAnotherNode) {
  for (const bool is_damaged : {false, true}) {
    const CommonFolder folder;
    const TestBuild build(folder);
    facts::FinishedNodes finished = store_nodes(build.workspace());
    if (!world().is_root()) continue;
    const scratch::RecordRef chunk = finished.nodes[20].chunk;
    if (is_damaged) {
      std::fstream file(path_of(build.workspace().scratch.folder, chunk.file),
                        std::ios::binary | std::ios::in | std::ios::out);
      file.seekp(static_cast<std::streamoff>(chunk.offset + chunk.size / 2));
      const char byte = static_cast<char>(file.peek() ^ 1);
      file.seekp(static_cast<std::streamoff>(chunk.offset + chunk.size / 2));
      file.put(byte);
    } else {
      finished.nodes[20].chunk = finished.nodes[21].chunk;
    }
    const auto error =
        error_of([&] { assemble(build.workspace(), made_up_catalog(), "diamonds", finished); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->status(), core::Status::kIo);
    EXPECT_FALSE(std::filesystem::exists(folder / "out.h5"));
    EXPECT_FALSE(std::filesystem::exists(folder / "out.h5.part"));
  }
}

TEST(Assemble, LeavesTheOutputToAnAttemptThatHasTakenOver) {
  const CommonFolder folder;
  const TestBuild build(folder);
  const facts::FinishedNodes finished = store_nodes(build.workspace());
  if (!world().is_root()) return;
  for (const facts::StoredNode& node : finished.nodes) build.workspace().reader.read(node.chunk);
  scratch::take_attempt(build.workspace().scratch.folder.parent_path(), 1);
  const auto error = error_of([&] { assemble(build.workspace(), made_up_catalog(), "diamonds", finished); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->status(), core::Status::kIo);
  EXPECT_NE(std::string(error->what()).find("another attempt"), std::string::npos) << error->what();
  EXPECT_FALSE(std::filesystem::exists(folder / "out.h5"));
}

}  // namespace
}  // namespace colossus::pipeline::nodes
