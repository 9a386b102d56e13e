// Triangles of the input that lattice or rounding took away, and what keeps their surface from being lost.
//
// A triangle whose corners fall together leaves a segment, or a point. Where the surface goes on, another
// triangle has that segment for an edge, and nothing is lost. But of a wire that is thinner than the grid, or
// of a crumb smaller than its spacing, nothing would be left, as far away from the rest as it may be. There
// two triangles stay, back to back over the segment and one more point of the grid: closed, as thin as can
// be.
#pragma once

#include <array>
#include <vector>

#include "mesh/mesh.hpp"
#include "pipeline/buckets/bucket_tree.hpp"

namespace colossus::pipeline::buckets {

struct LostTriangle {
  std::array<mesh::Vertex, 3> corners;  // as they lie now; at least two are equal, unless it was a fin
  // Lattice units: how far what stands for it is from where it lies now; of fins.
  double displacement = 0.0;
  bool is_fin() const {
    return !mesh::is_degenerate(corners[0].position, corners[1].position, corners[2].position);
  }
};

struct Revived {
  std::uint64_t pairs = 0;  // of triangles that were added, of segments whose lesser end the cube holds
  // Triangles of the mesh from this one on were added.
  std::size_t first = 0;
};

// Adds what is needed to the mesh of a bucket, welded, whose lost triangles these are. `spacing`, of the grid
// on which positions lie, in lattice units: what is added reaches as far beyond its segment. Depends on
// nothing but the segment, and on the triangles that have it for an edge, or their corner in the cube; so all
// buckets do the same. Linear.
Revived revive_lost(const std::vector<LostTriangle>& lost, std::int32_t spacing, const CubeId& cube,
                    mesh::Mesh& mesh);

}  // namespace colossus::pipeline::buckets
