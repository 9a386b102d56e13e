#include "pipeline/blocks/cube_store.hpp"

#include "codec/coded/renumber.hpp"
#include "mesh/topology.hpp"
#include "pipeline/facts/catalog.hpp"

namespace colossus::pipeline::blocks {

std::vector<std::uint32_t> order_cube(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count,
                                      const codec::Codec& codec) {
  codec.order(triangles, vertex_count);
  return codec::coded::renumber_by_first_use(triangles, vertex_count);
}

CubeRecord store_cube(const run::Workspace& workspace, const hierarchy::CubeId& id,
                      const nodes::SampledMesh& content, double displacement) {
  const mesh::Mesh& mesh = content.mesh;
  std::vector<bool> is_rim(mesh.vertices.size(), true);
  for (const mesh::Triangle& t : mesh.triangles)
    for (const auto v : t) is_rim[v] = false;
  CubeRecord record;
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles)) {
    if (edge.count() != 2)
      is_rim[edge.a] = is_rim[edge.b] = true;
    else
      record.inconsistent_edges += edge.forward != edge.backward ? 1 : 0;
  }
  std::vector<geometry::Point> rim;
  for (std::size_t v = 0; v < is_rim.size(); ++v)
    if (is_rim[v]) rim.push_back(mesh.vertices[v].position);
  record.id = id;
  record.displacement = displacement;
  record.triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  record.vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  record.mesh = store(workspace, content);
  record.rim =
      workspace.writer.append(static_cast<std::uint32_t>(facts::RecordKind::kRim), core::as_bytes(rim));
  return record;
}

std::vector<geometry::Point> load_rim(const run::Workspace& workspace, const scratch::RecordRef& record) {
  const core::Bytes bytes = workspace.reader.read(record);
  return core::ByteReader(bytes).get_array<geometry::Point>(bytes.size() / sizeof(geometry::Point));
}

}  // namespace colossus::pipeline::blocks
