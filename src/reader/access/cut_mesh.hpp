// The surface of a cut of any scheme as one indexed mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::reader::access {

struct CutMesh {
  std::vector<std::array<double, 3>> positions;      // world
  std::vector<std::array<std::uint8_t, 2>> normals;  // octahedral codes; empty when the container has none
  std::vector<mesh::Color> colors;                   // empty when the container has none
  std::vector<mesh::Triangle> triangles;
  std::uint64_t stored_triangles = 0;  // before dropping

  // Appends a position and returns its index; the attributes are left to the caller. Throws
  // Error(kNoResources) for more than 2^31 - 1 vertices.
  std::uint32_t add_position(const std::array<double, 3>& world);
};

// Welds vertices by their world positions, bit by bit: the first one's attributes stay. Equal exact positions
// have equal world positions; where the origin is so far away that different ones have as well, an
// independent program would weld them, so we do. Drops triangles with two equal positions, and vertices that
// no triangle uses any more. Two opposite triangles with the same corners are surface, a plate without
// thickness, and stay.
void weld(CutMesh& mesh);

}  // namespace colossus::reader::access
