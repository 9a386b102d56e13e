// What exact cuts leave of triangles that are narrower than a lattice unit where a plane of the hierarchy
// crosses them.
#pragma once

#include <cstdint>

#include "hierarchy/diamond.hpp"
#include "mesh/mesh.hpp"

namespace colossus::pipeline::diamonds {

// Welds the mesh of a tetrahedron. Pieces whose corners have fallen together are segments; where no triangle
// has such a segment for an edge, as at the tip of a needle, two triangles back to back stand for it, with a
// third corner inside the tetrahedron, at most two cells of the input's lattice from the segment. Returns how
// many pairs were added. A segment within a face has none: what is there belongs to both sides. Linear.
std::uint64_t weld_cut(const hierarchy::Tetrahedron& tetrahedron, mesh::Mesh& mesh);

}  // namespace colossus::pipeline::diamonds
