// What a vertex may do while its node is simplified.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/adjacency.hpp"
#include "simplify/region.hpp"

namespace colossus::simplify {

enum class VertexClass : std::uint8_t {
  kFree,    // on no face, surrounded by triangles: may be placed anew
  kFace,    // on inner faces only
  kBorder,  // on the input's own border
  kLocked,  // on an outer face, non-manifold, or with neighbours of the other orientation
};

// Linear.
std::vector<VertexClass> classify_vertices(const Region& region, const mesh::Adjacency& adjacency);

}  // namespace colossus::simplify
