#include "codec/vertex_order.hpp"

#include <meshoptimizer.h>

#include <algorithm>

namespace colossus::codec {

void order_for_cache(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count) {
  if (triangles.empty()) return;
  std::vector<unsigned int> ordered(triangles.size() * 3);
  meshopt_optimizeVertexCache(ordered.data(), triangles.front().data(), ordered.size(), vertex_count);
  std::copy(ordered.begin(), ordered.end(), triangles.front().data());
}

}  // namespace colossus::codec
