#include "codec/node_codec.hpp"

#include "codec/planes.hpp"

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

void put_tetrahedron(ByteWriter& writer, const NodeMesh& node, const QuantizedTetrahedron& part) {
  const std::size_t width = weight_bytes(node.position_bits);
  for (std::size_t corner = 0; corner < 3; ++corner)
    for (const Weights& w : part.weights) put_sized(writer, w[corner], width);
  writer.put_array<std::uint8_t>(part.marks);
  if (node.has_normals) put_normals(writer, part.normals);
  if (node.has_colors) put_colors(writer, part.colors);
  put_triangles(writer, part.triangles, part.weights.size());
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
  const std::uint64_t triangle_start = reader.offset();
  const auto indices = reader.get_bytes(triangle_plane_bytes(n, counts.triangles));
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
  part.normals = normals_of(normals);
  part.colors = colors_of(colors);
  auto triangles = triangles_of(indices, counts.vertices, counts.triangles, triangle_start);
  if (!triangles) return triangles.defect();
  if (triangles.value().used_vertices != counts.vertices)
    return Defect{"a vertex is used by no triangle", triangle_start};
  part.triangles = std::move(triangles.value().triangles);
  return part;
}

}  // namespace

core::Bytes encode(const NodeMesh& node) {
  ByteWriter writer;
  const auto flags =
      static_cast<std::uint8_t>((node.has_normals ? kNormalsFlag : 0) | (node.has_colors ? kColorsFlag : 0));
  put_start(writer, {kCodec, kVersion, static_cast<std::uint8_t>(node.position_bits), flags,
                     static_cast<std::uint8_t>(node.tetrahedra.size())});
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
