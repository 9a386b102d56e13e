// Closed surfaces cut into the tetrahedra of one level, as a build does it, and what quantisation leaves of
// them.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "codec/quantization/quantize.hpp"
#include "geometry/vector.hpp"

namespace colossus::codec {

using Random = std::mt19937_64;

struct Cell {
  hierarchy::Tetrahedron tetrahedron;
  mesh::Mesh mesh;  // welded
};

// The tetrahedra of this level that hold something of the mesh.
std::vector<Cell> clip_to_cells(const mesh::Mesh& mesh, int level);

// A cell as its readers see it: positions that are equal between cells where they coincide.
struct SeenCell {
  hierarchy::Tetrahedron tetrahedron;
  std::vector<coded::ScaledPosition> positions;
  std::vector<std::uint8_t> marks;  // bit i: on the face opposite corner i
  std::vector<mesh::Triangle> triangles;
};
SeenCell unquantised(const Cell& cell);
SeenCell quantised(const Cell& cell, int bits);

// Edges of the whole, welded by position, without the triangles that this makes degenerate.
struct EdgeCounts {
  std::size_t degenerate = 0;   // triangles
  std::size_t nonmanifold = 0;  // more than two triangles
  std::size_t unbalanced = 0;   // not as many in one direction as in the other
};
EdgeCounts count_edges(const std::vector<SeenCell>& cells);

// Edges within the faces of cells, but for those along a face's own edges, which other faces share.
struct FaceEdges {
  std::size_t count = 0;
  // Those that one side has more often than the other side has their reverse, each side net.
  std::size_t differing = 0;
};
FaceEdges compare_faces(const std::vector<SeenCell>& cells);

// A closed ellipsoid with these half axes; its points are moved by up to `noise` of their distance to the
// centre.
mesh::Mesh ellipsoid(Random& random, const geometry::Vec3& center,
                     const std::array<geometry::Vec3, 3>& half_axes, std::uint32_t segments, double noise);

void append(mesh::Mesh& mesh, const mesh::Mesh& other);

// The same mesh with vertices, triangles and their corners in another order.
mesh::Mesh shuffled(const mesh::Mesh& mesh, Random& random);

}  // namespace colossus::codec
