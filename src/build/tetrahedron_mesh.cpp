#include "build/tetrahedron_mesh.hpp"

#include "build/catalog.hpp"

namespace colossus::build {

TetrahedronRecord store(const Workspace& workspace, const hierarchy::TetrahedronId& id,
                        const TetrahedronMesh& content) {
  const std::array<std::uint64_t, 3> counts{content.mesh.vertices.size(), content.mesh.triangles.size(),
                                            content.samples.size()};
  TetrahedronRecord entry;
  entry.id = id;
  entry.vertices = static_cast<std::uint32_t>(counts[0]);
  entry.triangles = static_cast<std::uint32_t>(counts[1]);
  entry.record =
      workspace.writer.append(static_cast<std::uint32_t>(RecordKind::kTetrahedron),
                              {std::as_bytes(std::span(counts)), core::as_bytes(content.mesh.vertices),
                               core::as_bytes(content.mesh.triangles), core::as_bytes(content.samples)});
  return entry;
}

TetrahedronMesh load(const Workspace& workspace, const scratch::RecordRef& record) {
  const core::Bytes bytes = workspace.reader.read(record);
  core::ByteReader reader(bytes);
  const auto counts = reader.get<std::array<std::uint64_t, 3>>();
  TetrahedronMesh content;
  content.mesh.vertices = reader.get_array<mesh::Vertex>(counts[0]);
  content.mesh.triangles = reader.get_array<mesh::Triangle>(counts[1]);
  content.samples = reader.get_array<simplify::SurfaceSample>(counts[2]);
  COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
  return content;
}

}  // namespace colossus::build
