// Writes a container whose payloads are laid out by hand, as schemas/container.md says, for
// read_container_test.py. Arguments: the file to write, and the number of extra nodes of level 15 (0 for a
// small file).
//
// Node 0 is the root diamond with tetrahedra at places 0 and 3; node 1 a diamond of level 1 with places 1
// and 3. Every tetrahedron has six vertices: its four corners in order, the middle of corners 0 and 3, and a
// point with weights (1, 2, 3, 2^12 - 6); three triangles, (0, 1, 2), (3, 4, 5) and (2, 0, 5).
#include <array>
#include <cstdlib>

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

void add_node(std::vector<container::NodeRow>& rows, std::vector<container::PackedChunk>& chunks,
              std::uint32_t level, std::array<std::int32_t, 3> center,
              const std::vector<std::uint8_t>& places) {
  chunks.push_back(container::pack_chunk(make_payload(places)));
  container::NodeRow row;
  row.level = level;
  row.center = center;
  for (const std::uint8_t place : places)
    row.tetra_mask = static_cast<std::uint8_t>(row.tetra_mask | (1 << place));
  row.flags = level == 0 ? std::uint8_t{0} : container::kNodeIsLeaf;
  row.vertices = static_cast<std::uint32_t>(kVertexCount * places.size());
  row.triangles = static_cast<std::uint32_t>(3 * places.size());
  row.error = 1.0 / (1 + level);
  row.capacity_class = chunks.back().capacity_class;
  row.stored_bytes = chunks.back().frame.size();
  row.payload_bytes = chunks.back().payload_bytes;
  row.checksum = chunks.back().checksum;
  rows.push_back(row);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  container::Metadata metadata;
  metadata.lattice = {{10, -20, 0.5}, 0.25, kRootBits};
  metadata.position_bits = kBits;
  metadata.has_normals = true;
  metadata.has_colors = true;
  std::vector<container::NodeRow> rows;
  std::vector<container::PackedChunk> chunks;
  constexpr std::int32_t kSide = 1 << kRootBits;
  add_node(rows, chunks, 0, {kSide / 2, kSide / 2, kSide / 2}, {0, 3});
  add_node(rows, chunks, 1, {kSide / 2, kSide / 2, 0}, {1, 3});
  // Cubes of side 32, numbered along x, y, z: level 15.
  const int extra = std::atoi(argv[2]);
  for (std::int32_t i = 0; i < extra; ++i)
    add_node(rows, chunks, 15, {16 + 32 * (i / 1024), 16 + 32 * (i / 32 % 32), 16 + 32 * (i % 32)},
             {0, 1, 2, 3, 4, 5});
  container::ContainerWriter writer(argv[1]);
  writer.add_nodes(metadata, rows);
  for (const auto& chunk : chunks) writer.append_chunk(chunk.frame);
  writer.commit();
  return 0;
}
