// Constrained edge collapse on flat arrays, in passes: the core of Colossus.
//
// Each pass computes quadrics afresh (Garland and Heckbert 1997; fresh ones halve the drift of accumulated
// ones, see src/README.md), sorts all candidate collapses by cost and applies the cheap ones whose ends no
// earlier collapse of the pass has touched. Legality is tested on live connectivity, just before a collapse:
//   - a may collapse into b only if a lies on no outer face and b lies on all faces that a lies on: by
//   convexity every
//     triangle stays in its cell (Balsa Rodríguez et al. 2013, section 4.2, made exact);
//   - no new edge joins two vertices with a common face beyond the faces of a, and no triangle comes to lie
//   flat in a
//     face: otherwise the surface would touch a face beside its polyline there;
//   - link condition (Dey et al. 1999): no edge becomes non-manifold, no two triangles fall together;
//   - no triangle turns over.
// Vertices of the input's own border collapse only along it; non-manifold vertices stay. Two free vertices,
// those on no face and no border, are replaced by the quadric's optimum when that lies strictly inside their
// cell; all other collapses move a to b.
//
// A region whose vertices may not be placed has half-edge collapses only: of two free vertices the cheaper
// end stays, or the other one where that is illegal. A collapse is legal then only if all vertices that have
// become a lie within the region's reach of b, which their bounding box tells exactly. If the region weighs
// colours, the quadrics are those of Garland and Heckbert 1998, in space and colour; those of borders stay in
// space, and the other end stays only if that costs no more than the pass accepts. Collapses onto locked
// vertices and along the borders of the regions that come next cost less than they do harm: borders that stay
// dense while the rest is thinned out are what would be seen (clefts, src/README.md).
//
// Where the target is not reached, components that lie within the error of what stays are dropped
// (simplify/components.hpp).
#pragma once

#include <vector>

#include "simplify/region.hpp"

namespace colossus::simplify {

// Memory of simplify(), bytes per triangle of the region: fitted to builds of statues (src/README.md). What
// the caller keeps beside the region is not in it. Where colours are weighed, quadrics are larger.
inline constexpr std::uint64_t kBytesPerTriangle = 250;
inline constexpr std::uint64_t kBytesPerWeighedTriangle = 320;

struct Outcome {
  std::uint64_t initial_triangles = 0;
  std::uint64_t final_triangles = 0;  // at most the target, or what the constraints left
  std::uint64_t initial_vertices = 0;
  std::uint64_t locked_vertices = 0;  // of the initial ones: on outer faces or non-manifold
  int passes = 0;
  double deviation =
      0.0;  // estimate of the greatest distance between this surface and the input, lattice units
  // For each vertex before: the number of the vertex after that it has become.
  std::vector<std::uint32_t> representative;
};

// Reduces the region to at most `target_triangles`, as far as it can, and updates its samples. Vertices left
// keep their order. Without `may_place` every vertex that has not collapsed is left, even if no triangle uses
// it, so that `representative` always names one; with `may_place` every vertex given must have a triangle.
// A finite reach needs `may_place` to be false. One to two million triangles per second; memory
// kBytesPerTriangle, or kBytesPerWeighedTriangle when colours are weighed. Deterministic.
Outcome simplify(Region& region, std::size_t target_triangles);

}  // namespace colossus::simplify
