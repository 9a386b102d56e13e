// The cubes' meshes in scratch.
#pragma once

#include "codec/codec.hpp"
#include "hierarchy/octree.hpp"
#include "pipeline/nodes/sampled_mesh.hpp"

namespace colossus::pipeline::blocks {

// A cube's mesh, on the lattice of 2^30. Its order is that of the buckets, or what simplification has left of
// it: it knows nothing of codecs, so that what simplification sees next does not depend on them.
struct CubeRecord {
  hierarchy::CubeId id;
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;
  scratch::RecordRef mesh;
  // Positions of the vertices that other cubes may use too: those on border edges of the cube's triangles,
  // and those that no triangle uses.
  scratch::RecordRef rim;
  // Edges that two of its triangles use in the same direction, and no others.
  std::uint64_t inconsistent_edges = 0;
  // By how much rounding the middles of split edges has moved the input's surface, lattice units; of the cube
  // or of those below it.
  double displacement = 0.0;
};

// Triangles into the codec's order, vertices into order of first use, those that no triangle uses after
// them: as a node stores them. Returns for each vertex its number before. Deterministic.
std::vector<std::uint32_t> order_cube(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count,
                                      const codec::Codec& codec);

CubeRecord store_cube(const run::Workspace& workspace, const hierarchy::CubeId& id,
                      const nodes::SampledMesh& content, double displacement);

std::vector<geometry::Point> load_rim(const run::Workspace& workspace, const scratch::RecordRef& record);

}  // namespace colossus::pipeline::blocks
