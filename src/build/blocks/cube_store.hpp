// The cubes' meshes in scratch.
#pragma once

#include "build/sampled_mesh.hpp"
#include "codec/codec.hpp"
#include "hierarchy/octree.hpp"

namespace colossus::build {

// A cube's mesh has the vertices in the order in which its node stores them, on the lattice of 2^30.
struct CubeRecord {
  hierarchy::CubeId id;
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;
  scratch::RecordRef mesh;
  // Positions of the vertices that other cubes may use too: those on border edges of the cube's triangles,
  // and those that no triangle uses.
  scratch::RecordRef rim;
  // By how much rounding the middles of split edges has moved the input's surface, lattice units; of the cube
  // or of those below it.
  double displacement = 0.0;
};

// Triangles into the codec's order, vertices into order of first use, those that no triangle uses after
// them. Returns for each vertex its number before.
std::vector<std::uint32_t> order_cube(mesh::Mesh& mesh, const codec::Codec& codec);

CubeRecord store_cube(const Workspace& workspace, const hierarchy::CubeId& id, const SampledMesh& content,
                      double displacement);

std::vector<geometry::Point> load_rim(const Workspace& workspace, const scratch::RecordRef& record);

}  // namespace colossus::build
