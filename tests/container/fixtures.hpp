// Containers for tests: payloads of arbitrary bytes, rows that describe them, and folders that vanish.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "container/chunk.hpp"
#include "container/reader.hpp"
#include "container/schema.hpp"
#include "container/writer.hpp"

namespace colossus::container::test {

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "colossus_container_XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  bool is_empty() const { return std::filesystem::is_empty(path_); }

 private:
  std::filesystem::path path_;
};

// Bytes that compress a little, and not to nothing: half of the values are small.
inline core::Bytes make_payload(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  core::Bytes payload(size);
  for (std::byte& b : payload) {
    const std::uint64_t bits = random();
    b = static_cast<std::byte>(bits % 2 == 0 ? bits >> 60 : bits >> 56);
  }
  return payload;
}

struct Sample {
  Metadata metadata;
  std::vector<NodeRow> rows;
  std::vector<core::Bytes> payloads;
  std::vector<PackedChunk> chunks;
};

// node_count rows in order, with payloads from 5 bytes to some 40 kB in several capacity classes.
inline Sample make_sample(std::size_t node_count) {
  Sample sample;
  Metadata& m = sample.metadata;
  m.scheme = "diamonds";
  m.lattice = {{-1.5, 2e5, 0.25}, 0.0078125, 20};
  m.position_bits = 12;
  m.has_normals = true;
  m.has_colors = true;
  m.options = {{"leaf_triangles", "8000"}, {"empty", ""}, {"tolerance", "0.001"}};
  m.parameters = {{"sigma0", 0.1}, {"a parameter", -4}};
  m.measures = {{"input_area", 1.5}};
  m.inputs = {{"scan 1.ply", 123456789012, "00112233445566778899aabbccddeeff"},
              {"b\xc3\xa4r.obj", 7, "ffeeddccbbaa99887766554433221100"}};
  m.counts = {{"triangles", 10}, {"degenerate", 0}, {"border edges", 1ULL << 40}};
  m.levels = {{"level", std::vector<std::uint64_t>{0, 1}}, {"error_max", std::vector<double>{0.5, 0.125}}};
  for (std::size_t i = 0; i < node_count; ++i) {
    NodeRow row;
    row.level = static_cast<std::uint32_t>(i / 64);
    const auto place = static_cast<std::int32_t>(i % 64);
    row.center = {place / 16 * 64, place / 4 % 4 * 64, place % 4 * 64};
    row.tetra_mask = static_cast<std::uint8_t>(i % 16);
    row.flags = i + 64 >= node_count ? kNodeIsLeaf : std::uint8_t{0};
    row.vertices = static_cast<std::uint32_t>(100 + i);
    row.triangles = static_cast<std::uint32_t>(200 + i);
    row.error = 1.0 / static_cast<double>(1 + i);
    row.bounds = {-1, -2, -3, static_cast<double>(i), 2, 3};
    sample.payloads.push_back(make_payload(i % 7 == 3 ? 5 : 1000 + (i * 7919) % 40000, i));
    sample.chunks.push_back(pack_chunk(sample.payloads.back()));
    const PackedChunk& chunk = sample.chunks.back();
    row.capacity_class = chunk.capacity_class;
    row.stored_bytes = chunk.frame.size();
    row.payload_bytes = chunk.payload_bytes;
    row.checksum = chunk.checksum;
    sample.rows.push_back(row);
  }
  return sample;
}

// The root cube of a lattice of 2^14, and its eight children of sides of 2^13.
inline Sample make_blocks_sample() {
  Sample sample = make_sample(9);
  sample.metadata.scheme = "blocks";
  sample.metadata.lattice.root_bits = 14;
  sample.metadata.position_bits = 13;
  for (std::size_t i = 0; i < 9; ++i) {
    NodeRow& row = sample.rows[i];
    row.level = i == 0 ? 0 : 1;
    row.flags = i == 0 ? std::uint8_t{0} : kNodeIsLeaf;
    row.tetra_mask = 1;
    const auto along = [&](std::size_t bit) { return (i - 1) >> bit & 1 ? 3 << 12 : 1 << 12; };
    row.center = {1 << 13, 1 << 13, 1 << 13};
    if (i > 0) row.center = {along(2), along(1), along(0)};
  }
  return sample;
}

inline void write_sample(const Sample& sample, const std::filesystem::path& path) {
  ContainerWriter writer(path);
  writer.add_nodes(sample.metadata, sample.rows);
  for (const PackedChunk& chunk : sample.chunks) writer.append_chunk(chunk.frame);
  writer.commit();
}

// The message and status of the Error that a call throws; kOk when it throws none.
struct Caught {
  core::Status status = core::Status::kOk;
  std::string message;
  bool says(const std::string& part) const { return message.find(part) != std::string::npos; }
};

template <typename Call>
Caught catch_error(Call call) {
  try {
    call();
  } catch (const core::Error& error) {
    return {error.status(), error.what()};
  }
  return {};
}

}  // namespace colossus::container::test
