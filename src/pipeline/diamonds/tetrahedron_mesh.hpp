// What the master knows of a tetrahedron's mesh in scratch.
#pragma once

#include "hierarchy/diamond.hpp"
#include "pipeline/nodes/sampled_mesh.hpp"

namespace colossus::pipeline::diamonds {

struct TetrahedronRecord {
  hierarchy::TetrahedronId id;
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;
  scratch::RecordRef record;
};

inline TetrahedronRecord store_tetrahedron(const run::Workspace& workspace,
                                           const hierarchy::TetrahedronId& id,
                                           const nodes::SampledMesh& content) {
  return {id, static_cast<std::uint32_t>(content.mesh.triangles.size()),
          static_cast<std::uint32_t>(content.mesh.vertices.size()), store(workspace, content)};
}

}  // namespace colossus::pipeline::diamonds
