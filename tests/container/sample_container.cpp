// Writes a container whose payloads are laid out by hand, as schemas/container.md says, for
// read_container_test.py. Arguments: the file to write, and the number of extra nodes of level 15 (0 for a
// small file), or the word "blocks"; and the codec: what is laid out by hand is that of "zstd", and what
// others hold is the same.
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

#include "codec/payload.hpp"
#include "container/chunk.hpp"
#include "container/writer.hpp"
#include "core/hash.hpp"

namespace {

using namespace colossus;

constexpr int kBits = 12;
constexpr int kRootBits = 10;
constexpr std::uint32_t kVertexCount = 6;

// The end of every payload's head, the sections and the checksum.
core::Bytes finish(core::ByteWriter& writer, const std::array<core::ByteWriter, 5>& sections) {
  for (const core::ByteWriter& section : sections) writer.put(static_cast<std::uint32_t>(section.size()));
  for (const core::ByteWriter& section : sections) writer.put_bytes(section.bytes());
  writer.put(core::hash64(writer.bytes()));
  return writer.take();
}

void put_tetrahedron(std::array<core::ByteWriter, 5>& sections) {
  auto& [connectivity, positions, normals, colors, parents] = sections;
  constexpr std::uint16_t kOne = 1 << kBits;
  const std::uint16_t weights[3][kVertexCount] = {
      {kOne, 0, 0, 0, kOne / 2, 1}, {0, kOne, 0, 0, 0, 2}, {0, 0, kOne, 0, 0, 3}};
  for (const auto& plane : weights) positions.put(plane);
  // About +z, three corners of the octahedron's square (all of them -z), and two others.
  const std::uint8_t u[kVertexCount] = {127, 0, 255, 255, 200, 60};
  const std::uint8_t v[kVertexCount] = {128, 0, 255, 0, 90, 220};
  normals.put(u);
  normals.put(v);
  for (std::uint8_t channel = 0; channel < 4; ++channel)
    for (std::uint8_t i = 0; i < kVertexCount; ++i) colors.put(static_cast<std::uint8_t>(10 * channel + i));
  // (0, 1, 2), (3, 4, 5), (2, 0, 5): six new vertices, then high water 6 minus the index.
  const std::uint8_t corners[9] = {0, 0, 0, 0, 0, 0, 4, 6, 1};
  connectivity.put(corners);
}

core::Bytes make_payload(const std::vector<std::uint8_t>& places) {
  core::ByteWriter writer;
  writer.put(std::array<std::uint8_t, 5>{3, 1, kBits, 3, static_cast<std::uint8_t>(places.size())});
  for (const std::uint8_t place : places) {
    writer.put(std::uint32_t{place} << 24);
    writer.put(kVertexCount);
    writer.put(std::uint32_t{3});
  }
  std::array<core::ByteWriter, 5> sections;
  for (std::size_t i = 0; i < places.size(); ++i) put_tetrahedron(sections);
  return finish(writer, sections);
}

// The same payload in another codec.
core::Bytes recoded(const core::Bytes& payload, const codec::Codec& codec) {
  constexpr codec::NodeCounts kMost{1000, 1000};
  return codec::to_payload(codec::from_payload(payload, kMost).value(), codec).bytes;
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
                 const std::vector<std::uint8_t>& places, const codec::Codec& codec) {
  nodes.chunks.push_back(container::pack_chunk(recoded(make_payload(places), codec)));
  container::NodeRow row = row_for(nodes.chunks.back(), level, center);
  for (const std::uint8_t place : places)
    row.tetra_mask = static_cast<std::uint8_t>(row.tetra_mask | (1 << place));
  row.vertices = static_cast<std::uint32_t>(kVertexCount * places.size());
  row.triangles = static_cast<std::uint32_t>(3 * places.size());
  nodes.rows.push_back(row);
}

// extra: of level 15, in cubes of side 32, numbered along x, y, z.
Nodes make_diamonds(std::int32_t extra, const codec::Codec& codec) {
  Nodes nodes;
  constexpr std::int32_t kSide = 1 << kRootBits;
  add_diamond(nodes, 0, {kSide / 2, kSide / 2, kSide / 2}, {0, 3}, codec);
  add_diamond(nodes, 1, {kSide / 2, kSide / 2, 0}, {1, 3}, codec);
  for (std::int32_t i = 0; i < extra; ++i)
    add_diamond(nodes, 15, {16 + 32 * (i / 1024), 16 + 32 * (i / 32 % 32), 16 + 32 * (i % 32)},
                {0, 1, 2, 3, 4, 5}, codec);
  return nodes;
}

// Positions relative to (5, 20, 0) in nine bits, so of two bytes each.
core::Bytes make_cube(std::uint8_t n, std::uint32_t triangle_count,
                      const std::vector<std::array<int, 3>>& points) {
  const bool is_child = n == 4;
  core::ByteWriter writer;
  writer.put(std::array<std::uint8_t, 5>{3, 1, 9, static_cast<std::uint8_t>(is_child ? 15 : 11), 1});
  constexpr std::uint32_t kIdentityFrame = 1367813;
  writer.put(std::array<std::uint32_t, 3>{kIdentityFrame, n, triangle_count});
  writer.put(std::array<std::int32_t, 3>{5, 20, 0});
  std::array<core::ByteWriter, 5> sections;
  auto& [connectivity, positions, normals, colors, parents] = sections;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const auto& p : points) positions.put(static_cast<std::uint16_t>(p[axis]));
  for (int component = 0; component < 2; ++component)
    for (std::uint8_t i = 0; i < n; ++i) normals.put(std::uint8_t{127});
  for (std::uint8_t channel = 0; channel < 4; ++channel)
    for (std::uint8_t i = 0; i < n; ++i) colors.put(static_cast<std::uint8_t>(10 * channel + i));
  if (is_child) {
    parents.put(std::array<std::uint8_t, 5>{1, 0, 1, 1, 0});
    connectivity.put(std::array<std::uint8_t, 6>{0, 0, 0, 1, 2, 3});
  }
  return finish(writer, sections);
}

Nodes make_blocks(const codec::Codec& codec) {
  const std::array<core::Bytes, 2> payloads{
      make_cube(2, 0, {{0, 0, 300}, {256, 0, 0}}),
      make_cube(4, 2, {{0, 0, 300}, {5, 1, 0}, {256, 0, 0}, {7, 7, 7}})};
  Nodes nodes;
  for (std::uint32_t level = 0; level < 2; ++level) {
    nodes.chunks.push_back(container::pack_chunk(recoded(payloads[level], codec)));
    const std::int32_t center = level == 0 ? 256 : 128;
    nodes.rows.push_back(row_for(nodes.chunks.back(), level, {center, center, center}));
    nodes.rows.back().tetra_mask = 1;
    nodes.rows.back().vertices = level == 0 ? 2 : 4;
    nodes.rows.back().triangles = level == 0 ? 0 : 2;
  }
  return nodes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const codec::Codec& codec = codec::codec_named(argv[3]);
  container::Metadata metadata;
  metadata.scheme = "diamonds";
  metadata.lattice = {{10, -20, 0.5}, 0.25, kRootBits};
  metadata.position_bits = kBits;
  metadata.has_normals = true;
  metadata.has_colors = true;
  const bool is_blocks = std::string(argv[2]) == "blocks";
  if (is_blocks) {
    metadata.scheme = "blocks";
    metadata.lattice.root_bits = 9;
    metadata.position_bits = 8;
    metadata.parameters = {{"sigma0", 0.25}, {"block_size", 4}};
  }
  const Nodes nodes = is_blocks ? make_blocks(codec) : make_diamonds(std::atoi(argv[2]), codec);
  container::ContainerWriter writer(argv[1]);
  writer.add_nodes(metadata, nodes.rows);
  for (const auto& chunk : nodes.chunks) writer.append_chunk(chunk.frame);
  writer.commit();
  return 0;
}
