// Distances between surfaces, by sampling one and measuring exactly to the other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::verify::measure {

using WorldPoint = std::array<double, 3>;

// Points and triangles, in world units where nothing else is said. Indices must be in range and coordinates
// finite. Distances are right where fourth powers of lengths neither overflow nor vanish: verify() scales.
struct Surface {
  std::span<const WorldPoint> points;
  std::span<const mesh::Triangle> triangles;
};

// Distances from points to the triangles of a surface: a tree of boxes over them. The surface's points are
// not copied and must outlive the index. Memory: some 20 bytes per triangle. Cost: n log n to build, on all
// usable processors; a few microseconds per distance.
class SurfaceIndex {
 public:
  // `surface` must have at least one triangle; anything else is a bug and ends the program.
  explicit SurfaceIndex(const Surface& surface);

  struct Nearest {
    double distance = 0.0;
    std::uint32_t triangle = 0;
  };
  // The distance from p to the surface. `near` is any triangle; one close to p makes it faster. Any triangle
  // that is no farther than `enough` will do, which is faster too; a larger distance is that of the nearest.
  // Thread-safe.
  Nearest nearest(const WorldPoint& p, std::uint32_t near = 0, double enough = 0.0) const;

  const Surface& surface() const { return surface_; }

 private:
  struct Box {
    WorldPoint low;
    WorldPoint high;
  };
  Box box_of(std::size_t begin, std::size_t end) const;
  void build(std::size_t node, std::size_t begin, std::size_t end, int depth);

  Surface surface_;
  std::vector<std::uint32_t> order_;  // triangles; a tree node is a range of it, halved down to the leaves
  std::vector<Box> boxes_;            // complete binary tree: the children of node k are 2k + 1 and 2k + 2
  int depth_ = 0;
};

// The distance from p to the closed triangle a b c, which may be degenerate.
double triangle_distance(const WorldPoint& p, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c);

// `count` points of the surface or a few fewer: up to half of them vertices of triangles, evenly strided, the
// others spread over the area, stratified, the same for the same seed and surface. Empty when there are no
// triangles.
std::vector<WorldPoint> sample_surface(const Surface& surface, std::size_t count, std::uint64_t seed);

struct OneSidedDistance {
  double rms = 0.0;  // over samples spread evenly by area
  double max = 0.0;  // over these and over vertices
};

struct SurfaceDistances {
  OneSidedDistance a_to_b;
  OneSidedDistance b_to_a;
};

// Both one-sided distances with `samples` samples each (half as many vertices beside them, for the maxima).
// Neither surface may be empty. On all usable processors; the result does not depend on their number.
SurfaceDistances surface_distances(const Surface& a, const Surface& b, std::size_t samples,
                                   std::uint64_t seed = 1);

}  // namespace colossus::verify::measure
