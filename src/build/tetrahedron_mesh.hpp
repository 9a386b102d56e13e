// The lattice mesh of one tetrahedron as it lies in scratch.
#pragma once

#include <vector>

#include "build/workspace.hpp"
#include "hierarchy/diamond.hpp"
#include "mesh/mesh.hpp"
#include "scratch/spool.hpp"
#include "simplify/region.hpp"

namespace colossus::build {

struct TetrahedronMesh {
  mesh::Mesh mesh;                               // welded; vertices in order of first use
  std::vector<simplify::SurfaceSample> samples;  // of the input; none for leaves, which are the input
};

// Where it lies, and what the master needs to know of it.
struct TetrahedronRecord {
  hierarchy::TetrahedronId id;
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;
  scratch::RecordRef record;
};

TetrahedronRecord store(const Workspace& workspace, const hierarchy::TetrahedronId& id,
                        const TetrahedronMesh& content);
TetrahedronMesh load(const Workspace& workspace, const scratch::RecordRef& record);

}  // namespace colossus::build
