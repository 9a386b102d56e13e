// What one task simplifies: the welded mesh of a node. Diamonds are cut into cells by faces that vertices may
// not leave; blocks are not cut, and their vertices stay where some vertex was.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
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
  std::uint16_t cell = 0;    // of the nearest triangle
  // 1: stands for all that was dropped and lies at its component; thin_out() keeps it.
  std::uint16_t is_pinned = 0;
};

struct Region {
  mesh::Mesh mesh;
  std::vector<FaceMask> faces;  // per vertex
  std::vector<std::uint16_t>
      cells;  // per triangle: the convex cell that holds it; or the caller's own number
  std::vector<SurfaceSample> samples;
  FaceMask outer_faces = 0;                                 // faces shared with others: vertices on them stay
  std::vector<std::array<geometry::Plane, 4>> cell_planes;  // per cell, positive inside; for placing only
  // False: half-edge collapses only. What remains of two vertices is one of them, attributes and all.
  bool may_place = true;
  // With half-edge collapses only: the greatest distance between a vertex before and the one that it has
  // become, in the maximum norm, lattice units.
  std::int64_t reach = std::numeric_limits<std::int64_t>::max();
  // The caller's error of the surface will not be less than this, lattice units: components that are no
  // farther from the rest may go, if the target is not reached without.
  double known_error = 0.0;
  // With half-edge collapses only: how many mean edge lengths of the region the greatest difference of a
  // colour channel counts in the error of a collapse. Alpha does not count.
  double color_weight = 0.0;
  // With half-edge collapses only, per cell: the region that its triangles will be in when they are
  // simplified next. Vertices between two of these will then be locked. Empty: not known.
  std::vector<std::uint16_t> next_regions;
};

// Triangles by their smallest angle; integer counts, so that sums over nodes do not depend on their order.
struct AngleCounts {
  std::uint64_t below_5_degrees = 0;
  std::uint64_t below_15_degrees = 0;
  std::uint64_t below_30_degrees = 0;
};
AngleCounts count_small_angles(const mesh::Mesh& mesh);

}  // namespace colossus::simplify
