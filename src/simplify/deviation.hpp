// How far a simplified surface lies from the input, measured, not added up.
//
// Adding up the steps of all levels overestimates tenfold. Instead each tetrahedron carries points of the
// input with it, each with the vertex it is nearest to; after every simplification their distances to the new
// surface are measured by a short walk from there. That is the one side, from the input to the surface. On
// the other side placed vertices and the middles of edges are measured against the surface that they were
// made of, and added to what that deviated there.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "simplify/region.hpp"

namespace colossus::simplify {

// What lies between the samples can be farther than they are: up to 1.13 times on the scans tried.
inline constexpr double kDeviationMargin = 1.5;

struct Deviation {
  double of_samples = 0.0;  // greatest distance of a sample to the surface, lattice units
  double of_surface = 0.0;  // greatest estimate for a placed vertex, or the middle of an edge

  double greatest() const { return std::max(of_samples, of_surface); }

  double estimate() const { return kDeviationMargin * greatest(); }
};

// `before` is the mesh that was simplified to `after`; `representative[v]` is the vertex of `after` into
// which v of `before` has collapsed. Moves the samples' anchors from `before` to `after` and updates their
// distances and cells. `cells` are after's. With `has_border` border edges are measured at three
// places: the surface may have grown beyond the input there. Vertices without triangles are no part of a
// surface; where `after` has no triangle left, samples are measured to their anchors' representatives, and
// keep their cells. About a quarter of a microsecond per sample.
Deviation measure_deviation(const mesh::Mesh& before, const mesh::Mesh& after,
                            std::span<const std::uint16_t> cells,
                            std::span<const std::uint32_t> representative, bool has_border,
                            std::vector<SurfaceSample>& samples);

// Attaches these samples to the nearest of all triangles, of which there is at least one.
void attach_to_nearest(const mesh::Mesh& mesh, std::span<const std::uint16_t> cells,
                       std::span<const std::uint32_t> which, std::vector<SurfaceSample>& samples);

// At most `count` of the samples that are not pinned: the farthest quarter of them, since what is far now is
// likely to be so at the next level, and others chosen by a hash of their positions. Deterministic, whatever
// the order of the samples.
void thin_out(std::vector<SurfaceSample>& samples, std::size_t count);

}  // namespace colossus::simplify
