#include "rivals.hpp"

#include <meshoptimizer.h>
#include <zstd.h>

#include <array>
#include <cmath>
#include <cstring>

#include "core/error.hpp"
#include "geometry/octahedral.hpp"

#ifdef COLOSSUS_HAS_DRACO
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#endif

namespace colossus::bench {
namespace {

using codec::coded::CodedNode;
using codec::coded::CodedPart;
using core::Bytes;
using core::Status;

constexpr int kZstdLevel = 3;

Bytes compressed(const Bytes& bytes) {
  Bytes result(ZSTD_compressBound(bytes.size()));
  result.resize(ZSTD_compress(result.data(), result.size(), bytes.data(), bytes.size(), kZstdLevel));
  return result;
}

Bytes decompressed(const Bytes& bytes) {
  Bytes result(ZSTD_getFrameContentSize(bytes.data(), bytes.size()));
  if (ZSTD_isError(ZSTD_decompress(result.data(), result.size(), bytes.data(), bytes.size())))
    core::fail(Status::kBadData, "zstd: cannot decompress");
  return result;
}

std::uint8_t* data_of(Bytes& bytes) { return reinterpret_cast<std::uint8_t*>(bytes.data()); }
const std::uint8_t* data_of(const Bytes& bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

// A vertex as meshoptimizer wants it, a multiple of four bytes.
struct VertexLayout {
  std::size_t coordinate_bytes = 2;
  std::size_t normal = 0;
  std::size_t color = 0;
  std::size_t stride = 0;
};

VertexLayout layout_of(const CodedNode& node) {
  VertexLayout layout;
  layout.coordinate_bytes = node.position_bits < 16 ? 2 : 4;
  layout.normal = 3 * layout.coordinate_bytes;
  layout.color = layout.normal + (node.has_normals ? 2 : 0);
  layout.stride = (layout.color + (node.has_colors ? 4 : 0) + 3) / 4 * 4;
  return layout;
}

RivalBytes encode_by_meshoptimizer(const CodedNode& node, const CodedPart& part) {
  const VertexLayout layout = layout_of(node);
  const std::size_t count = part.positions.size();
  const std::size_t index_count = 3 * part.triangles.size();
  std::vector<std::uint32_t> indices(index_count);
  meshopt_optimizeVertexCacheStrip(indices.data(), part.triangles[0].data(), index_count, count);
  std::vector<std::uint8_t> vertices(count * layout.stride);
  for (std::size_t v = 0; v < count; ++v) {
    std::uint8_t* at = vertices.data() + v * layout.stride;
    for (std::size_t i = 0; i < 3; ++i)
      std::memcpy(at + i * layout.coordinate_bytes, &part.positions[v][i], layout.coordinate_bytes);
    if (node.has_normals) std::memcpy(at + layout.normal, &part.normals[v], 2);
    if (node.has_colors) std::memcpy(at + layout.color, &part.colors[v], 4);
  }
  const std::size_t used = meshopt_optimizeVertexFetch(vertices.data(), indices.data(), index_count,
                                                       vertices.data(), count, layout.stride);
  RivalBytes result;
  result.vertex_count = used;
  Bytes bytes(meshopt_encodeIndexBufferBound(index_count, count));
  bytes.resize(meshopt_encodeIndexBuffer(data_of(bytes), bytes.size(), indices.data(), index_count));
  result.indices = compressed(bytes);
  bytes.resize(meshopt_encodeVertexBufferBound(used, layout.stride));
  bytes.resize(
      meshopt_encodeVertexBuffer(data_of(bytes), bytes.size(), vertices.data(), used, layout.stride));
  result.rest = compressed(bytes);
  return result;
}

void decode_by_meshoptimizer(const CodedNode& node, const CodedPart& part, const RivalBytes& bytes) {
  const VertexLayout layout = layout_of(node);
  std::vector<std::uint32_t> indices(3 * part.triangles.size());
  std::vector<std::uint8_t> vertices(bytes.vertex_count * layout.stride);
  const Bytes index_bytes = decompressed(bytes.indices);
  const Bytes vertex_bytes = decompressed(bytes.rest);
  if (meshopt_decodeIndexBuffer(indices.data(), indices.size(), sizeof(std::uint32_t), data_of(index_bytes),
                                index_bytes.size()) != 0 ||
      meshopt_decodeVertexBuffer(vertices.data(), bytes.vertex_count, layout.stride, data_of(vertex_bytes),
                                 vertex_bytes.size()) != 0)
    core::fail(Status::kBadData, "meshoptimizer: cannot decode");
}

#ifdef COLOSSUS_HAS_DRACO

constexpr int kDracoSpeed = 3;  // level 7
constexpr int kNormalBits = 8;

// Of equal root-mean-square error: errors of ours are uniform in cells spanned by the frame's rows, Draco's
// in cubes.
double draco_step(const CodedNode& node, const CodedPart& part) {
  if (node.is_on_lattice()) return 1.0;
  double squares = 0.0;
  for (const auto& row : part.frame)
    for (const int entry : row) squares += entry * entry;
  return std::sqrt(squares / 3.0);
}

template <typename T>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data_type,
                  std::int8_t components, const std::vector<T>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, components, data_type, data_type == draco::DT_UINT8, sizeof(T), 0);
  const int id = mesh.AddAttribute(attribute, true, mesh.num_points());
  for (std::uint32_t v = 0; v < values.size(); ++v)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &values[v]);
  return id;
}

RivalBytes encode_by_draco(const CodedNode& node, const CodedPart& part) {
  draco::Mesh mesh;
  const auto count = static_cast<std::uint32_t>(part.positions.size());
  mesh.set_num_points(count);
  mesh.SetNumFaces(part.triangles.size());
  for (std::uint32_t t = 0; t < part.triangles.size(); ++t)
    mesh.SetFace(draco::FaceIndex(t),
                 {{draco::PointIndex(part.triangles[t][0]), draco::PointIndex(part.triangles[t][1]),
                   draco::PointIndex(part.triangles[t][2])}});
  const double step = draco_step(node, part);
  std::vector<std::array<std::int32_t, 3>> positions(count);
  for (std::uint32_t v = 0; v < count; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (std::size_t i = 0; i < 3; ++i)
        sum += static_cast<double>(part.positions[v][i]) * part.frame[i][axis];
      positions[v][axis] = static_cast<std::int32_t>(std::lround(sum / step));
    }
  add_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_INT32, 3, positions);
  int normals = -1;
  if (node.has_normals) {
    std::vector<std::array<float, 3>> values(count);
    for (std::uint32_t v = 0; v < count; ++v) {
      const auto n = geometry::decode_octahedral(part.normals[v]);
      values[v] = {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
    }
    normals = add_attribute(mesh, draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3, values);
  }
  if (node.has_colors) {
    std::vector<std::array<std::uint8_t, 3>> values(count);
    for (std::uint32_t v = 0; v < count; ++v)
      values[v] = {part.colors[v][0], part.colors[v][1], part.colors[v][2]};
    add_attribute(mesh, draco::GeometryAttribute::COLOR, draco::DT_UINT8, 3, values);
  }
  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(kDracoSpeed, kDracoSpeed);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  if (normals >= 0) encoder.SetAttributeQuantization(normals, kNormalBits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) core::fail(Status::kBadData, "draco: cannot encode");
  RivalBytes result;
  result.rest.resize(buffer.size());
  std::memcpy(result.rest.data(), buffer.data(), buffer.size());
  return result;
}

void decode_by_draco(const CodedNode&, const CodedPart&, const RivalBytes& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.rest.data()), bytes.rest.size());
  draco::Decoder decoder;
  if (!decoder.DecodeMeshFromBuffer(&buffer).ok()) core::fail(Status::kBadData, "draco: cannot decode");
}

#endif

}  // namespace

const std::vector<Rival>& rivals() {
  static const std::vector<Rival> all{
#ifdef COLOSSUS_HAS_DRACO
      {"draco -cl 7", &encode_by_draco, &decode_by_draco},
#endif
      {"meshopt + zstd", &encode_by_meshoptimizer, &decode_by_meshoptimizer}};
  return all;
}

}  // namespace colossus::bench
