// The diamonds scheme's answers about one diamond: how the halves of its tetrahedra become one mesh, and
// which faces its vertices may not leave (Balsa Rodríguez et al. 2013, section 4.2; src/README.md).
#pragma once

#include <span>

#include "pipeline/diamonds/tetrahedron_mesh.hpp"
#include "simplify/region.hpp"

namespace colossus::pipeline::diamonds {

// A mesh that lies within the tetrahedron at `place` of the diamond.
struct PlacedMesh {
  std::uint32_t place = 0;
  nodes::SampledMesh content;
};

// Welds the parts by position; equal positions take the first one's attributes. Every
// vertex gets a bit for each face of the diamond's tetrahedra that it lies on exactly: up to 8 inner faces,
// which hold the long edge, and up to 16 outer ones.
simplify::Region make_region(const hierarchy::Diamond& diamond, std::span<const PlacedMesh> parts);

// The region's triangles by place; vertices in order of first use.
std::vector<PlacedMesh> split_region(const simplify::Region& region, const hierarchy::Diamond& diamond);

}  // namespace colossus::pipeline::diamonds
