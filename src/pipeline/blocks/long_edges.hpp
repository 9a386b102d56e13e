// Splits edges that are too long for the cubes of the deepest level.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "geometry/vector.hpp"
#include "mesh/mesh.hpp"
#include "pipeline/buckets/buckets.hpp"
#include "pipeline/buckets/lost_triangles.hpp"

namespace colossus::pipeline::blocks {

// The point of the grid that is nearest to the middle of two others, of several the even one, so that
// successive rounds do not drift. Between them on every axis. Points of the grid are multiples of `spacing`,
// at least 0.
geometry::Point middle_on_grid(const geometry::Point& a, const geometry::Point& b, std::int32_t spacing);

// Splits the edges of a mesh that are too long at their middles, rounded to the grid, round by round, and
// welds. What becomes of a triangle depends on nothing but its corners, and each edge is split alike by all
// of its triangles.
class LongEdgeSplitter {
 public:
  // `longest` in the maximum norm. The mesh lies on the grid.
  LongEdgeSplitter(std::int64_t longest, std::int32_t spacing, mesh::Mesh& mesh);

  // Returns how many edges were split whose lesser end lies in the cube.
  std::uint64_t run(const hierarchy::CubeId& cube);

  // Triangles that collapsed when the middles of their edges were rounded, in pieces that are not too long.
  const std::vector<buckets::LostTriangle>& lost() const { return lost_; }

  // How far a point of the triangle is at most from its place in the triangle that this one was a part of:
  // that of its corners that rounding has moved farthest. Lattice units; 0 for what was not split.
  double displacement(std::uint32_t triangle) const;

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  // Where the corners of a part would be without rounding.
  using Corners = std::array<geometry::Vec3, 3>;

  bool split_once(const hierarchy::CubeId& cube);
  void split_lost();
  void divide(const mesh::Triangle& t, const Corners& corners, const std::array<std::uint32_t, 3>& middle,
              std::vector<mesh::Triangle>& triangles, std::vector<Corners>& parts) const;
  std::uint32_t middle_of(std::uint32_t a, std::uint32_t b, const hierarchy::CubeId& cube);
  Corners corners_of(std::uint32_t triangle) const;
  const geometry::Point& at(std::uint32_t v) const { return mesh_.vertices[v].position; }

  std::int64_t longest_;
  std::int32_t spacing_;
  mesh::Mesh& mesh_;
  std::vector<std::uint32_t> part_of_;  // per triangle: the number of its part, or kNone
  std::vector<Corners> parts_;
  std::vector<buckets::LostTriangle> lost_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles_;  // by edge, of this round
  std::uint64_t count_ = 0;
};

}  // namespace colossus::pipeline::blocks
