// The diamond hierarchy as pure index arithmetic: nothing is stored, a diamond is its centre.
//
// Longest-edge bisection of the six Kuhn tetrahedra of the root cube (Balsa Rodríguez et al. 2013, section
// 4.1; Weiss and De
// Floriani 2010). All tetrahedra around one longest edge are a diamond, identified by the edge's midpoint,
// its centre. Level l = 3k + t has cubes of side h = 2^(30-k): for t = 0 the long edge is a cube's diagonal
// (6 tetrahedra), for t = 1 a square's diagonal (4), for t = 2 a cube's edge (8). Diamonds at the hull of the
// root cube have fewer inside it; a place is nevertheless numbered among all. The reader's contract is in
// schemas/container.md.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/plane.hpp"
#include "geometry/point.hpp"

namespace colossus::hierarchy {

// The scheme whose nodes are diamonds, in containers and options.
inline constexpr const char* kDiamonds = "diamonds";

using geometry::Plane;
using geometry::Point;

// Corners of cells stay at multiples of 8 (geometry/lattice.hpp), which ends the hierarchy.
inline constexpr int kMaxLevel = 78;

// A tetrahedron; corners in global (lexicographic) order.
struct Tetrahedron {
  std::array<Point, 4> corners;
  friend auto operator<=>(const Tetrahedron&, const Tetrahedron&) = default;

  // The centre of the diamond it belongs to: the midpoint of its longest edge.
  Point center() const;
  // Indices of the two ends of its longest edge, in order.
  std::array<int, 2> long_edge() const;
  // The plane of the face opposite corner i, positive on the tetrahedron's side.
  Plane face_plane(int i) const;
  // The plane that bisects it, positive on the side of the first end of the long edge.
  Plane bisector() const;
  // The half with end 0 (side +) or end 1 (side -) of the long edge.
  Tetrahedron child(int end) const;
  bool is_inside_root() const;
  // Whether p lies in the closed tetrahedron.
  bool contains(const Point& p) const;
};

// The level of the diamond with this centre; negative for a corner of the root cube, which is no diamond's
// centre.
int level_of(const Point& center);

struct Diamond {
  Point center;
  int level = 0;
  std::array<Point, 2> ends;              // of the long edge, in order
  int place_count = 0;                    // 6, 4 or 8
  std::array<Tetrahedron, 8> tetrahedra;  // by place, in order
  std::array<bool, 8> is_inside{};        // within the root cube

  static Diamond at(const Point& center);
  // The place of a tetrahedron of this diamond; a foreign one is a bug and ends the program.
  int place_of(const Tetrahedron& tetrahedron) const;
  // The diamonds whose splits make this one's tetrahedra: none for the root, else up to 3, 2 or 4.
  std::vector<Point> parents() const;
};

// Names a tetrahedron: its diamond and its place in it.
struct TetrahedronId {
  Point center;
  std::uint32_t place = 0;
  friend auto operator<=>(const TetrahedronId&, const TetrahedronId&) = default;
};

struct TetrahedronIdHash {
  std::size_t operator()(const TetrahedronId& id) const {
    return geometry::PointHash{}(id.center) ^ core::mix64(id.place + 1);
  }
};

TetrahedronId id_of(const Tetrahedron& tetrahedron);
Tetrahedron tetrahedron_of(const TetrahedronId& id);

inline Point root_center() {
  return {geometry::kRootSide / 2, geometry::kRootSide / 2, geometry::kRootSide / 2};
}

// The three planes that part the root cube into its six tetrahedra, entered in this order by everybody.
std::array<Plane, 3> root_planes();

}  // namespace colossus::hierarchy
