// The finest level as a whole, compared with what the container stores of it and of
// the input.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "codec/coded/weights.hpp"
#include "geometry/point.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify::measure {

// Of one part of the finest level, or of all.
struct FinestSurface {
  double area = 0.0;        // square lattice units
  double rounding = 0.0;    // what an honest computation of it in doubles can be off
  geometry::Bounds bounds;  // world; of vertices that triangles use
  double greatest_error = 0.0;
  std::uint64_t triangles = 0;  // as stored
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
  bool is_whole = true;  // nothing was damaged
  void add(const FinestSurface& part);
};

// Adds the areas of triangles whose positions are integers, `units` to the lattice unit; exact but for the
// rounding of each area and of their sum.
void add_area(FinestSurface& part, std::span<const codec::coded::ScaledPosition> positions,
              std::span<const mesh::Triangle> triangles, double units);

// The bounds of the vertices that the input's triangles use, where the container has them all.
std::optional<geometry::Bounds> stored_bounds(const reader::access::Statue& statue);

// Triangles, area, bounds, border and non-manifold edges; a note instead where the container stores none.
// Nothing when a leaf is damaged.
void check_finest(const reader::access::Statue& statue, const FinestSurface& finest, FindingLog& log);

}  // namespace colossus::verify::measure
