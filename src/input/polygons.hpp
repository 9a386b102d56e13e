// Polygons that blocks deliver as fans, cut as their corners on the lattice want it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/polygon.hpp"
#include "input/source.hpp"

namespace colossus::input {

// Polygons that the fan from the first corner would not do for, or that no triangles do for.
struct OddPolygons {
  std::uint64_t concave = 0;
  std::uint64_t warped = 0;    // corners far off their own plane: triangulated as they are seen along it
  std::uint64_t crossing = 0;  // cross themselves: triangulated as well as can be

  void merge(const OddPolygons& other) {
    concave += other.concave;
    warped += other.warped;
    crossing += other.crossing;
  }
};

class PolygonCutter {
 public:
  // Replaces a fan by other triangles over the same corners. `position_of(index)` is a geometry::Point.
  template <typename PositionOf>
  void cut(std::span<std::array<std::uint32_t, 3>> fan, const PositionOf& position_of) {
    indices_.assign({fan[0][0], fan[0][1]});
    for (const auto& triangle : fan) indices_.push_back(triangle[2]);
    points_.clear();
    for (const std::uint32_t index : indices_) points_.push_back(position_of(index));
    const geometry::PolygonTriangles result = triangulator_.triangulate(points_);
    odd_.concave += result.kind == geometry::PolygonKind::kConcave;
    odd_.warped += result.kind == geometry::PolygonKind::kWarped;
    odd_.crossing += result.kind == geometry::PolygonKind::kCrossing;
    for (std::size_t i = 0; i < fan.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) fan[i][k] = indices_[result.triangles[i][k]];
  }
  const OddPolygons& odd() const { return odd_; }

 private:
  geometry::PolygonTriangulator triangulator_;
  std::vector<std::uint32_t> indices_;
  std::vector<geometry::Point> points_;
  OddPolygons odd_;
};

}  // namespace colossus::input
