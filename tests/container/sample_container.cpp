// Writes a container whose payloads are laid out by hand, as schemas/container.md says, for
// read_container_test.py. Arguments: the file to write, and the number of extra nodes of level 15 (0 for a
// small file), or the word "blocks".
//
// Node 0 is the root diamond with tetrahedra at places 0 and 3; node 1 a diamond of level 1 with places 1
// and 3. Every tetrahedron has six vertices: its four corners in order, the middle of corners 0 and 3, and a
// point with weights (1, 2, 3, 2^12 - 6); three triangles, (0, 1, 2), (3, 4, 5) and (2, 0, 5).
//
// Blocks: node 0 is the root cube of side 2^9 with two vertices and no triangle, node 1 its child at the
// origin with four vertices and the triangles (0, 1, 2) and (2, 1, 0), which leave vertex 3 unused.
#include <array>
#include <cstdlib>
#include <string>

#include "container/chunk.hpp"
#include "container/writer.hpp"
#include "core/bytes.hpp"

namespace {

using namespace colossus;

constexpr int kBits = 12;
constexpr int kRootBits = 10;
constexpr std::uint32_t kVertexCount = 6;

void put_tetrahedron(core::ByteWriter& writer) {
  constexpr std::uint16_t kOne = 1 << kBits;
  const std::uint16_t weights[3][kVertexCount] = {
      {kOne, 0, 0, 0, kOne / 2, 1}, {0, kOne, 0, 0, 0, 2}, {0, 0, kOne, 0, 0, 3}};
  for (const auto& plane : weights) writer.put(plane);
  const std::uint8_t marks[kVertexCount] = {0b1110, 0b1101, 0b1011, 0b0111, 0b0110, 0};
  writer.put(marks);
  // Normals: about +z, three corners of the octahedron's square (all of them -z), and two others.
  const std::uint8_t u[kVertexCount] = {127, 0, 255, 255, 200, 60};
  const std::uint8_t v[kVertexCount] = {128, 0, 255, 0, 90, 220};
  writer.put(u);
  writer.put(v);
  for (std::uint8_t channel = 0; channel < 4; ++channel)
    for (std::uint8_t i = 0; i < kVertexCount; ++i) writer.put(static_cast<std::uint8_t>(10 * channel + i));
  // (0, 1, 2), (3, 4, 5), (2, 0, 5): six new vertices, then high water 6 minus the index.
  const std::uint8_t corners[9] = {0, 0, 0, 0, 0, 0, 4, 6, 1};
  writer.put(corners);
}

core::Bytes make_payload(const std::vector<std::uint8_t>& places) {
  core::ByteWriter writer;
  writer.put(std::array<std::uint8_t, 5>{1, 1, kBits, 3, static_cast<std::uint8_t>(places.size())});
  for (const std::uint8_t place : places) {
    writer.put(place);
    writer.put(kVertexCount);
    writer.put(std::uint32_t{3});
  }
  for (std::size_t i = 0; i < places.size(); ++i) put_tetrahedron(writer);
  return writer.take();
}

container::NodeRow row_for(const container::PackedChunk& chunk, std::uint32_t level,
                           std::array<std::int32_t, 3> center) {
  container::NodeRow row;
  row.level = level;
  row.center = center;
  row.flags = level == 0 ? std::uint8_t{0} : container::kNodeIsLeaf;
  row.error = 1.0 / (1 + level);
  row.capacity_class = chunk.capacity_class;
  row.stored_bytes = chunk.frame.size();
  row.payload_bytes = chunk.payload_bytes;
  row.checksum = chunk.checksum;
  return row;
}

struct Nodes {
  std::vector<container::NodeRow> rows;
  std::vector<container::PackedChunk> chunks;
};

void add_diamond(Nodes& nodes, std::uint32_t level, std::array<std::int32_t, 3> center,
                 const std::vector<std::uint8_t>& places) {
  nodes.chunks.push_back(container::pack_chunk(make_payload(places)));
  container::NodeRow row = row_for(nodes.chunks.back(), level, center);
  for (const std::uint8_t place : places)
    row.tetra_mask = static_cast<std::uint8_t>(row.tetra_mask | (1 << place));
  row.vertices = static_cast<std::uint32_t>(kVertexCount * places.size());
  row.triangles = static_cast<std::uint32_t>(3 * places.size());
  nodes.rows.push_back(row);
}

// extra: of level 15, in cubes of side 32, numbered along x, y, z.
Nodes make_diamonds(std::int32_t extra) {
  Nodes nodes;
  constexpr std::int32_t kSide = 1 << kRootBits;
  add_diamond(nodes, 0, {kSide / 2, kSide / 2, kSide / 2}, {0, 3});
  add_diamond(nodes, 1, {kSide / 2, kSide / 2, 0}, {1, 3});
  for (std::int32_t i = 0; i < extra; ++i)
    add_diamond(nodes, 15, {16 + 32 * (i / 1024), 16 + 32 * (i / 32 % 32), 16 + 32 * (i % 32)},
                {0, 1, 2, 3, 4, 5});
  return nodes;
}

// Positions relative to (5, 20, 0) in nine bits, so in two planes per axis, the low bytes first.
void put_cube(core::ByteWriter& writer, std::uint8_t n, std::uint32_t triangle_count,
              const std::vector<std::array<int, 3>>& positions) {
  const auto flags = static_cast<std::uint8_t>(n == 4 ? 7 : 3);
  writer.put(std::array<std::uint8_t, 5>{2, 1, flags, 9, static_cast<std::uint8_t>(n == 4 ? 1 : 0)});
  writer.put(std::array<std::uint32_t, 2>{n, triangle_count});
  writer.put(std::array<std::int32_t, 3>{5, 20, 0});
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int shift : {0, 8})
      for (const auto& p : positions) writer.put(static_cast<std::uint8_t>(p[axis] >> shift));
  for (int component = 0; component < 2; ++component)
    for (std::uint8_t i = 0; i < n; ++i) writer.put(std::uint8_t{127});
  for (std::uint8_t channel = 0; channel < 4; ++channel)
    for (std::uint8_t i = 0; i < n; ++i) writer.put(static_cast<std::uint8_t>(10 * channel + i));
}

Nodes make_blocks() {
  core::ByteWriter root;
  put_cube(root, 2, 0, {{0, 0, 300}, {256, 0, 0}});
  core::ByteWriter child;
  put_cube(child, 4, 2, {{0, 0, 300}, {5, 1, 0}, {256, 0, 0}, {7, 7, 7}});
  child.put(std::array<std::uint8_t, 4>{0, 1, 1, 0});
  child.put(std::array<std::uint8_t, 6>{0, 0, 0, 1, 2, 3});
  Nodes nodes;
  for (core::ByteWriter* writer : {&root, &child}) {
    nodes.chunks.push_back(container::pack_chunk(writer->take()));
    const bool is_root = writer == &root;
    const std::int32_t center = is_root ? 256 : 128;
    nodes.rows.push_back(row_for(nodes.chunks.back(), is_root ? 0 : 1, {center, center, center}));
    nodes.rows.back().tetra_mask = 1;
    nodes.rows.back().vertices = is_root ? 2 : 4;
    nodes.rows.back().triangles = is_root ? 0 : 2;
  }
  return nodes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  container::Metadata metadata;
  metadata.lattice = {{10, -20, 0.5}, 0.25, kRootBits};
  metadata.position_bits = kBits;
  metadata.has_normals = true;
  metadata.has_colors = true;
  const bool is_blocks = std::string(argv[2]) == "blocks";
  if (is_blocks) {
    metadata.scheme = container::kSchemeBlocks;
    metadata.lattice.root_bits = 9;
    metadata.position_bits = 8;
    metadata.parameters = {{"sigma0", 0.25}, {"block_size", 4}};
  }
  const Nodes nodes = is_blocks ? make_blocks() : make_diamonds(std::atoi(argv[2]));
  container::ContainerWriter writer(argv[1]);
  writer.add_nodes(metadata, nodes.rows);
  for (const auto& chunk : nodes.chunks) writer.append_chunk(chunk.frame);
  writer.commit();
  return 0;
}
