// The surface that the kernels are measured on: a torus with the relief of a scan, strictly inside one
// tetrahedron.
#pragma once

#include "hierarchy/diamond.hpp"
#include "simplify/region.hpp"

namespace colossus::bench {

// The tetrahedron of the root diamond that holds the torus.
hierarchy::Tetrahedron cell();

// A closed, manifold mesh of 4 * rings * rings triangles in an order with locality: a torus with three
// octaves of relief and noise of a tenth of an edge.
mesh::Mesh torus(std::uint32_t rings);

// The mesh as the only cell of a region, carrying `sample_count` of its vertices as samples.
simplify::Region region_of(const mesh::Mesh& mesh, std::size_t sample_count);

}  // namespace colossus::bench
