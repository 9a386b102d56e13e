// A node of the blocks scheme as it is stored: uncut triangles, exact lattice positions, and for each vertex
// the index of its parent vertex in the parent cube (paper 001, section 3.2).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/point.hpp"
#include "mesh/mesh.hpp"

namespace colossus::codec::coded {

// All vertex arrays have one entry per vertex, or none where the attribute is absent. Vertices in order of
// first use by the triangles, then those that only children's parent maps point to.
struct CubeMesh {
  bool has_normals = false;
  bool has_colors = false;
  bool has_parents = false;                          // not at level 0
  std::vector<geometry::Point> positions;            // on the container's lattice, absolute
  std::vector<std::array<std::uint8_t, 2>> normals;  // octahedral
  std::vector<mesh::Color> colors;
  std::vector<std::uint32_t> parents;  // indices into the parent cube's vertices
  std::vector<mesh::Triangle> triangles;
  friend bool operator==(const CubeMesh&, const CubeMesh&) = default;
};

}  // namespace colossus::codec::coded
