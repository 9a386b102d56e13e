// Triangles of one polygon of lattice points, by exact integers.
//
// The polygon is seen along its own plane: Newell's normal, the sum of the cross products of a fan
// (Sutherland, Sproull and Schumacker, A characterization of ten hidden-surface algorithms, ACM Computing
// Surveys 6, 1974; Tampieri, Newell's method for the plane equation of a polygon, Graphics Gems III, 1992,
// V.5), and the coordinate plane in which its area is greatest. A convex polygon is the fan from its first
// corner. Any other loses ears: corners whose triangle with both neighbours holds no other corner, of which a
// simple polygon has two (Meisters, Polygons have ears, American Mathematical Monthly 82, 1975). Only corners
// that are not convex need to be looked for in an ear, and a cut changes the two neighbours alone (Held,
// FIST: fast industrial-strength triangulation of polygons, Algorithmica 30, 2001, sections 2 and 3), so
// there are at most three searches a corner. Departures from FIST: all decisions are exact; the search is in
// a tree of boxes over the corners in Morton order instead of a grid; a corner that touches an ear's border
// counts where one of its edges goes into the ear, which keeps holes that are joined by a bridge, and corners
// in one place, without a special case.
//
// A certificate decides what was reached: no triangle is turned over in the projection, that is, the
// triangles' areas add up to the polygon's.
//
// Guaranteed for every input: corners - 2 triangles, so that each edge of the polygon is an edge of just one
// triangle and in its direction, and each other edge is one of two triangles and in both directions: a closed
// mesh stays closed whatever the polygon is like. The same triangles whenever the corners are the same. For a
// simple polygon, flat corners included: no triangle is turned over or, if the polygon is not convex,
// collinear. For one that touches itself (a bridge run through twice, corners or edges in one place, spikes):
// none is turned over in any case we have seen; the kind says so. For one that crosses itself: the best of a
// few tries, the fan from the first corner among them. One that overlaps itself like the roof of a car park
// may be covered fold by fold, and is then no kCrossing. One whose sides come closer to each other than the
// lattice's spacing may cross itself on the lattice although it does not in the input.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/point.hpp"

namespace colossus::geometry {

enum class PolygonKind : std::uint8_t {
  kConvex,  // the fan from the first corner; also triangles, and what has no area: collinear or equal corners
  kConcave,   // covered exactly, seen along its own plane
  kWarped,    // as either of these, but farther off its own plane than a twentieth of its box's greatest side
  kCrossing,  // some triangles are turned over: it crosses itself
};

struct PolygonTriangles {
  PolygonKind kind = PolygonKind::kConvex;
  // Indices into the corners, wound like the polygon. Valid until the next call.
  std::span<const std::array<std::uint32_t, 3>> triangles;
};

// Of the way from the plane in the middle of its corners to the farthest of them. Input vertices lie at
// multiples of eight units, so that rounding alone moves a corner by up to seven: twice that is never called
// warped.
inline constexpr int kWarpedFraction = 20;  // of the greatest side of the box
inline constexpr std::int64_t kWarpedUnits = 16;

// Keeps its memory between polygons: some 100 bytes for a corner of the greatest that was not convex.
class PolygonTriangulator {
 public:
  // `corners`: from 3 to 2^32 - 1, coordinates from 0 to kRootSide.
  // O(n) and without memory of its own but for the triangles if the polygon is convex; a quad takes some 40
  // ns. Otherwise O(n log n) for outlines as they occur (100,000 corners of a spiral, a comb, a star: 0.1 to
  // 0.3 s), and O(n^2) at worst, where ears are large and many corners lie close to them.
  PolygonTriangles triangulate(std::span<const Point> corners);

 private:
  using Triangle = std::array<std::uint32_t, 3>;
  struct Flat {
    std::int64_t u = 0;
    std::int64_t v = 0;
    friend bool operator==(const Flat&, const Flat&) = default;
  };
  struct Corner {
    Flat at;
    std::uint32_t previous = 0;
    std::uint32_t next = 0;
    std::size_t ticket = 0;  // its last place in the queue
    std::uint32_t slot = 0;  // in order_
    bool is_cut = false;
    bool is_obstacle = false;  // not strictly convex: counted in the tree
  };
  struct Box {
    Flat low;
    Flat high;
    std::uint32_t obstacles = 0;
  };
  // How much is put up with, from an ear without blemish to anything at all.
  enum class Patience : std::uint8_t { kEar, kTouchedEar, kCollinear, kEitherSide, kAnything };

  PolygonKind triangulate_quad(std::span<const Point> corners);
  PolygonKind triangulate_any(std::span<const Point> corners);
  PolygonKind cut_ears(std::span<const Point> corners, const std::array<__int128, 3>& normal);
  void make_fan(std::uint32_t first, std::uint32_t count);

  // The ear search of one projection.
  void project(std::span<const Point> corners, int axis, bool is_positive);
  void plant_tree();
  __int128 search(std::uint32_t start);
  void begin_search(std::uint32_t start);
  void serve_queue();
  std::uint32_t cut(std::uint32_t corner);
  void take_triangle(std::uint32_t corner);
  __int128 turned_over_in_fan() const;
  bool is_acceptable(std::uint32_t corner, Patience patience) const;
  bool is_needless(std::uint32_t corner) const;
  bool is_free(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool may_touch) const;
  bool is_blocked_by(const std::array<Flat, 3>& ear, std::uint32_t corner, bool may_touch) const;
  std::int64_t turn_at(std::uint32_t corner) const;
  void look_at(std::uint32_t corner);
  void set_obstacle(std::uint32_t corner, bool is_obstacle);

  std::vector<Triangle> triangles_;
  std::vector<Triangle> best_;
  std::vector<Corner> corners_;
  std::vector<std::uint32_t> order_;  // corners in Morton order: a leaf of the tree is kLeaf of them
  std::vector<std::uint64_t> keys_;
  std::vector<Box> tree_;  // children of i at 2 i and 2 i + 1
  std::vector<std::uint32_t> queue_;
  std::size_t served_ = 0;    // of the queue
  std::uint32_t left_ = 0;    // corners that are not cut
  __int128 turned_over_ = 0;  // of the triangles so far, twice the area
  std::size_t first_leaf_ = 0;
  bool cuts_slits_ = false;  // every second try: spikes that cross the rest look like slits
};

}  // namespace colossus::geometry
