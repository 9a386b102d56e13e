// Edges and their triangles: borders and non-manifold edges.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::mesh {

// An undirected edge: ends in index order, how many triangles use it in each direction.
struct Edge {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t forward = 0;   // triangles with a -> b
  std::uint32_t backward = 0;  // triangles with b -> a
  std::uint32_t count() const { return forward + backward; }
  bool is_border() const { return count() == 1; }
  bool is_nonmanifold() const { return count() > 2; }
};

// All edges, sorted by ends. n log n.
std::vector<Edge> edges(std::span<const Triangle> triangles);

}  // namespace colossus::mesh
