// The triangles of one bucket with their vertices, ready to be cut or assigned.
#pragma once

#include "build/buckets.hpp"
#include "mesh/mesh.hpp"

namespace colossus::build {

// Welded by position, in the order of the input's faces, without duplicates. Counts duplicates and edges in
// the one bucket that is to count them. Memory: some 150 bytes per triangle.
class BucketMesh {
 public:
  // `store` has the vertices. When these were rounded after the survey, `unrounded` has them as they were:
  // triangles that rounding has made equal are no duplicates of the input's; two of opposite orientation
  // cancel, and others stay, or the surface would open.
  BucketMesh(const Workspace& workspace, const VertexStore& store, const Cube& cube,
             std::span<const scratch::RecordRef> records, const VertexStore* unrounded = nullptr);

  mesh::Mesh& mesh() { return mesh_; }
  std::uint64_t duplicates() const { return duplicates_; }
  std::uint64_t border_edges() const { return border_edges_; }
  std::uint64_t nonmanifold_edges() const { return nonmanifold_edges_; }

 private:
  void index(const std::vector<BucketTriangle>& triangles, const VertexStore& store);
  void drop_duplicates(const std::vector<BucketTriangle>& triangles, const std::vector<std::uint32_t>& order,
                       const VertexStore* unrounded);
  void count_edges();
  const geometry::Point& position(std::uint32_t v) const { return mesh_.vertices[v].position; }

  Cube cube_;
  mesh::Mesh mesh_;
  std::uint64_t duplicates_ = 0;
  std::uint64_t border_edges_ = 0;
  std::uint64_t nonmanifold_edges_ = 0;
};

}  // namespace colossus::build
