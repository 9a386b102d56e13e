// The triangles of one bucket as one mesh, with the attributes of the positions in its cube.
#pragma once

#include "build/buckets.hpp"
#include "mesh/mesh.hpp"

namespace colossus::build {

struct BucketCounts {
  std::uint64_t merged_vertices = 0;
  std::uint64_t attribute_seams = 0;
  std::uint64_t duplicates = 0;
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
};

// Welded by position, in the order of the input's faces, without duplicates. A bucket owns the positions in
// its cube: it sees all triangles around them, and only it gives them attributes. The others have those of
// some vertex until complete(). Counts are of positions that the bucket owns, of duplicates whose least
// corner, and of edges whose lesser end it owns.
//
// The normal of a position is the sum of the normals that its vertices were read with, or else of the cross
// products of all triangles around it, duplicates too: 128-bit integers, which depend on no order. Colours
// are averaged. Where positions are rounded, this is done before, then normals and colours of all vertices
// that share a rounded position are averaged, each vertex counted once. Triangles that rounding has made
// equal are no duplicates of the input's; two of opposite orientation cancel, and others stay, or the surface
// would open.
class BucketMesh {
 public:
  // Memory: bucket_mesh_bytes().
  BucketMesh(const Rounding& rounding, const Cube& cube, Piece&& piece);

  mesh::Mesh& mesh() { return mesh_; }
  const BucketCounts& counts() const { return counts_; }

 private:
  void place(Piece&& piece);
  void give_attributes();
  void sum_cross_products(std::vector<bool>& is_unknown);
  void average_rounded();
  void round_positions(const Rounding& rounding);
  void drop_duplicates();
  void count_edges();
  bool owns(std::uint32_t v) const { return cube_.contains(mesh_.vertices[v].position); }
  bool owns_place(std::uint32_t place) const {
    return cube_.contains(rounding_(places_.vertices[place].position));
  }

  // A vertex at a place that another one, of another number, has taken.
  struct Other {
    std::uint32_t place;
    mesh::Normal16 normal;
    mesh::Color color;
    std::uint64_t number;
  };

  Rounding rounding_;
  Cube cube_;
  mesh::Mesh places_;  // welded before rounding
  std::vector<Other> others_;
  std::vector<std::uint32_t> vertex_counts_;  // per place
  mesh::Mesh mesh_;
  std::vector<mesh::Triangle> corners_;  // per triangle of mesh_, its places; empty without rounding
  BucketCounts counts_;
};

// An upper estimate of the greatest memory of a BucketMesh and of what a scheme then does with it.
std::uint64_t bucket_mesh_bytes(std::uint64_t triangles, std::uint64_t vertices_of_pieces);

}  // namespace colossus::build
