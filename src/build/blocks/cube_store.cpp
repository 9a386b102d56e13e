#include "build/blocks/cube_store.hpp"

#include "build/catalog.hpp"
#include "codec/vertex_order.hpp"
#include "mesh/topology.hpp"

namespace colossus::build {

std::vector<std::uint32_t> order_cube(mesh::Mesh& mesh) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  codec::order_for_cache(mesh.triangles, mesh.vertices.size());
  std::vector<std::uint32_t> renumbered(mesh.vertices.size(), kNone);
  std::vector<std::uint32_t> before;
  const auto take = [&](std::uint32_t v) {
    if (renumbered[v] != kNone) return;
    renumbered[v] = static_cast<std::uint32_t>(before.size());
    before.push_back(v);
  };
  for (mesh::Triangle& t : mesh.triangles)
    for (auto& v : t) {
      take(v);
      v = renumbered[v];
    }
  for (std::uint32_t v = 0; v < renumbered.size(); ++v) take(v);
  std::vector<mesh::Vertex> vertices;
  vertices.reserve(before.size());
  for (const auto v : before) vertices.push_back(mesh.vertices[v]);
  mesh.vertices = std::move(vertices);
  return before;
}

CubeRecord store_cube(const Workspace& workspace, const hierarchy::CubeId& id, const SampledMesh& content,
                      double displacement) {
  const mesh::Mesh& mesh = content.mesh;
  std::vector<bool> is_rim(mesh.vertices.size(), true);
  for (const mesh::Triangle& t : mesh.triangles)
    for (const auto v : t) is_rim[v] = false;
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles))
    if (edge.count() != 2) is_rim[edge.a] = is_rim[edge.b] = true;
  std::vector<geometry::Point> rim;
  for (std::size_t v = 0; v < is_rim.size(); ++v)
    if (is_rim[v]) rim.push_back(mesh.vertices[v].position);
  CubeRecord record;
  record.id = id;
  record.displacement = displacement;
  record.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  record.vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  record.mesh = store(workspace, content);
  record.rim = workspace.writer.append(static_cast<std::uint32_t>(RecordKind::kRim), core::as_bytes(rim));
  return record;
}

std::vector<geometry::Point> load_rim(const Workspace& workspace, const scratch::RecordRef& record) {
  const core::Bytes bytes = workspace.reader.read(record);
  return core::ByteReader(bytes).get_array<geometry::Point>(bytes.size() / sizeof(geometry::Point));
}

}  // namespace colossus::build
