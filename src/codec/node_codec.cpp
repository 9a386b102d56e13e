#include "codec/node_codec.hpp"

namespace colossus::codec {
namespace {

using core::ByteReader;
using core::ByteWriter;
using core::Defect;

constexpr std::uint8_t kCodec = 1;
constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kNormalsFlag = 1;
constexpr std::uint8_t kColorsFlag = 2;
constexpr std::uint8_t kMaxPlaces = 8;

// A weight can be 2^bits itself, at a corner.
std::size_t weight_bytes(int position_bits) { return position_bits < 16 ? 2 : 4; }
// What is stored can be as large as the number of vertices: vertex 0, seen after the last new one.
std::size_t index_bytes(std::size_t vertex_count) {
  return vertex_count <= 0xff ? 1 : vertex_count <= 0xffff ? 2 : 4;
}

void put_sized(ByteWriter& writer, std::uint32_t value, std::size_t bytes) {
  writer.put_bytes(std::as_bytes(std::span<const std::uint32_t, 1>(&value, 1)).first(bytes));
}

std::uint32_t get_sized(std::span<const std::byte> plane, std::size_t index, std::size_t bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, plane.data() + index * bytes, bytes);
  return value;
}

void put_tetrahedron(ByteWriter& writer, const NodeMesh& node, const QuantizedTetrahedron& part) {
  const std::size_t width = weight_bytes(node.position_bits);
  for (std::size_t corner = 0; corner < 3; ++corner)
    for (const Weights& w : part.weights) put_sized(writer, w[corner], width);
  writer.put_array<std::uint8_t>(part.marks);
  if (node.has_normals)
    for (std::size_t component = 0; component < 2; ++component)
      for (const auto& n : part.normals) writer.put(n[component]);
  if (node.has_colors)
    for (std::size_t component = 0; component < 4; ++component)
      for (const auto& c : part.colors) writer.put(c[component]);
  // Counted back from the highest index so far: small numbers, 0 for a new vertex.
  std::uint32_t high_water = 0;
  const std::size_t size = index_bytes(part.weights.size());
  for (const mesh::Triangle& t : part.triangles)
    for (const std::uint32_t v : t) {
      COLOSSUS_CHECK(v <= high_water, "vertices are not in order of first use");
      put_sized(writer, high_water - v, size);
      if (v == high_water) ++high_water;
    }
}

struct Counts {
  std::uint8_t place;
  std::uint32_t vertices;
  std::uint32_t triangles;
};

core::Result<QuantizedTetrahedron> get_tetrahedron(ByteReader& reader, const NodeMesh& node,
                                                   const Counts& counts) {
  const std::uint64_t n = counts.vertices;
  const std::size_t width = weight_bytes(node.position_bits);
  const std::uint64_t start = reader.offset();
  std::array<std::span<const std::byte>, 3> weight_planes;
  for (auto& plane : weight_planes) plane = reader.get_bytes(n * width);
  QuantizedTetrahedron part;
  part.place = counts.place;
  const auto marks = reader.get_bytes(n);
  const auto normals = reader.get_bytes(node.has_normals ? 2 * n : 0);
  const auto colors = reader.get_bytes(node.has_colors ? 4 * n : 0);
  const std::size_t size = index_bytes(counts.vertices);
  const auto indices = reader.get_bytes(3 * std::uint64_t{counts.triangles} * size);
  if (reader.failed()) return Defect{"the node is cut short", start};

  const std::uint32_t sum = std::uint32_t{1} << node.position_bits;
  part.weights.resize(n);
  part.marks.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    Weights& w = part.weights[i];
    std::uint64_t total = 0;
    for (std::size_t corner = 0; corner < 3; ++corner)
      total += w[corner] = get_sized(weight_planes[corner], i, width);
    if (total > sum) return Defect{"barycentric weights exceed their sum", start + i * width};
    w[3] = sum - static_cast<std::uint32_t>(total);
    part.marks[i] = std::to_integer<std::uint8_t>(marks[i]);
    if (part.marks[i] != marks_of(w))
      return Defect{"a vertex's face marks are not those of its weights", start + i};
  }
  if (node.has_normals) {
    part.normals.resize(n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < 2; ++k)
        part.normals[i][k] = std::to_integer<std::uint8_t>(normals[k * n + i]);
  }
  if (node.has_colors) {
    part.colors.resize(n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < 4; ++k)
        part.colors[i][k] = std::to_integer<std::uint8_t>(colors[k * n + i]);
  }
  part.triangles.resize(counts.triangles);
  std::uint32_t high_water = 0;
  for (std::size_t corner = 0; corner < 3 * std::size_t{counts.triangles}; ++corner) {
    const std::uint32_t back = get_sized(indices, corner, size);
    if (back > high_water || (back == 0 && high_water >= counts.vertices))
      return Defect{"a vertex index is out of range", start};
    part.triangles[corner / 3][corner % 3] = high_water - back;
    if (back == 0) ++high_water;
  }
  if (high_water != counts.vertices) return Defect{"a vertex is used by no triangle", start};
  return part;
}

}  // namespace

core::Bytes encode(const NodeMesh& node) {
  ByteWriter writer;
  writer.put(kCodec);
  writer.put(kVersion);
  writer.put(static_cast<std::uint8_t>(node.position_bits));
  writer.put(
      static_cast<std::uint8_t>((node.has_normals ? kNormalsFlag : 0) | (node.has_colors ? kColorsFlag : 0)));
  writer.put(static_cast<std::uint8_t>(node.tetrahedra.size()));
  for (const QuantizedTetrahedron& part : node.tetrahedra) {
    writer.put(part.place);
    writer.put(static_cast<std::uint32_t>(part.weights.size()));
    writer.put(static_cast<std::uint32_t>(part.triangles.size()));
  }
  for (const QuantizedTetrahedron& part : node.tetrahedra) put_tetrahedron(writer, node, part);
  return writer.take();
}

core::Result<NodeMesh> decode(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  const auto codec = reader.get<std::uint8_t>();
  const auto version = reader.get<std::uint8_t>();
  NodeMesh node;
  node.position_bits = reader.get<std::uint8_t>();
  const auto flags = reader.get<std::uint8_t>();
  const auto count = reader.get<std::uint8_t>();
  if (reader.failed()) return Defect{"the node's header is cut short", 0};
  if (codec != kCodec || version != kVersion)
    return Defect{
        fmt::format("codec {} version {} is unknown; this program reads codec 1 version 1", codec, version),
        0};
  if (node.position_bits < kMinPositionBits || node.position_bits > kMaxPositionBits)
    return Defect{"position bits out of range", 2};
  if (flags > (kNormalsFlag | kColorsFlag)) return Defect{"unknown attribute flags", 3};
  if (count > kMaxPlaces) return Defect{"too many tetrahedra", 4};
  node.has_normals = (flags & kNormalsFlag) != 0;
  node.has_colors = (flags & kColorsFlag) != 0;
  std::vector<Counts> counts;
  for (int i = 0; i < count; ++i) {
    Counts entry{};
    entry.place = reader.get<std::uint8_t>();
    entry.vertices = reader.get<std::uint32_t>();
    entry.triangles = reader.get<std::uint32_t>();
    if (entry.place >= kMaxPlaces || (!counts.empty() && entry.place <= counts.back().place))
      return Defect{"tetrahedra are not in order of their places", reader.offset()};
    counts.push_back(entry);
  }
  if (reader.failed()) return Defect{"the node's header is cut short", reader.offset()};
  for (const Counts& entry : counts) {
    auto part = get_tetrahedron(reader, node, entry);
    if (!part) return part.defect();
    node.tetrahedra.push_back(std::move(part).value());
  }
  if (reader.remaining() != 0) return Defect{"bytes left over after the last tetrahedron", reader.offset()};
  return node;
}

}  // namespace colossus::codec
