#include "pipeline/nodes/sampled_mesh.hpp"

#include "pipeline/facts/catalog.hpp"
#include "simplify/deviation.hpp"

namespace colossus::pipeline::nodes {

scratch::RecordRef store(const run::Workspace& workspace, const SampledMesh& content) {
  const std::array<std::uint64_t, 3> counts{content.mesh.vertices.size(), content.mesh.triangles.size(),
                                            content.samples.size()};
  return workspace.writer.append(static_cast<std::uint32_t>(facts::RecordKind::kMesh),
                                 {std::as_bytes(std::span(counts)), core::as_bytes(content.mesh.vertices),
                                  core::as_bytes(content.mesh.triangles), core::as_bytes(content.samples)});
}

SampledMesh load(const run::Workspace& workspace, const scratch::RecordRef& record) {
  const core::Bytes bytes = workspace.reader.read(record);
  core::ByteReader reader(bytes);
  const auto counts = reader.get<std::array<std::uint64_t, 3>>();
  SampledMesh content;
  content.mesh.vertices = reader.get_array<mesh::Vertex>(counts[0]);
  content.mesh.triangles = reader.get_array<mesh::Triangle>(counts[1]);
  content.samples = reader.get_array<simplify::SurfaceSample>(counts[2]);
  COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
  workspace.reporter.add_triangles(counts[1]);
  return content;
}

void add_missing_samples(SampledMesh& content) {
  if (!content.samples.empty()) return;
  for (std::uint32_t v = 0; v < content.mesh.vertices.size(); ++v)
    content.samples.push_back({content.mesh.vertices[v].position, v, 0.0F, 0});
  simplify::thin_out(content.samples, kSamplesPerMesh);
}

}  // namespace colossus::pipeline::nodes
