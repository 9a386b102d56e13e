// The planes of the hierarchy, sides of points as exact integers, and exact cuts of edges.
//
// Design: every plane has a normal e_i or e_i +- e_j, and corners lie at multiples of 8. A cut point is the
// exact rational intersection, each coordinate rounded half to even in the absolute coordinate. That rounding
// maps equal coordinates to equal ones and c - x to c - round(x) for even c, so the rounded point lies
// exactly on the cutting plane and on every other plane of the hierarchy that the whole edge lies on; and it
// is monotone, so nothing leaves a closed tetrahedron. The point depends on the edge and on the line or plane
// it ends up on, on nothing else.
#pragma once

#include <array>
#include <cstdint>

#include "geometry/point.hpp"

namespace colossus::geometry {

struct Plane {
  std::array<std::int8_t, 3> normal{};  // each -1, 0 or 1
  std::int64_t offset = 0;

  // Positive on the side that the normal points to, 0 exactly on the plane; below 2^33 in magnitude.
  std::int64_t side(const Point& p) const {
    return std::int64_t{normal[0]} * p.x + std::int64_t{normal[1]} * p.y + std::int64_t{normal[2]} * p.z -
           offset;
  }
};

// The plane through three corners, oriented so that `above` has a positive side. The plane must be one of the
// hierarchy's; anything else is a bug and ends the program.
Plane plane_through(const Point& a, const Point& b, const Point& c, const Point& above);

// Where the edge between p and q crosses a plane: side_p and side_q are their sides, of opposite signs.
Point cut_edge(const Point& p, const Point& q, std::int64_t side_p, std::int64_t side_q);

}  // namespace colossus::geometry
