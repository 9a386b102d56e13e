// What one task simplifies: the welded mesh of a node, cut into cells by faces that its vertices may not
// leave.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/plane.hpp"
#include "mesh/mesh.hpp"

namespace colossus::simplify {

// A bit per face of the cells that a vertex lies on.
using FaceMask = std::uint32_t;

// A point of the input that is carried along to measure how far the surface deviates from it.
struct SurfaceSample {
  mesh::Point position;
  std::uint32_t anchor = 0;  // a vertex of the nearest triangle
  float distance = 0.0F;     // to the surface, lattice units
  std::uint32_t cell = 0;    // of the nearest triangle
};

struct Region {
  mesh::Mesh mesh;
  std::vector<FaceMask> faces;      // per vertex
  std::vector<std::uint8_t> cells;  // per triangle: the convex cell that holds it
  std::vector<SurfaceSample> samples;
  FaceMask outer_faces = 0;                                 // faces shared with others: vertices on them stay
  std::vector<std::array<geometry::Plane, 4>> cell_planes;  // per cell, positive inside
};

// Triangles by their smallest angle; integer counts, so that sums over nodes do not depend on their order.
struct AngleCounts {
  std::uint64_t below_5_degrees = 0;
  std::uint64_t below_15_degrees = 0;
  std::uint64_t below_30_degrees = 0;
};
AngleCounts count_small_angles(const mesh::Mesh& mesh);

}  // namespace colossus::simplify
