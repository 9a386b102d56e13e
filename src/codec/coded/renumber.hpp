// Vertices in order of first use by triangles.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::codec::coded {

// Renumbers vertices by first use, those that no triangle uses after them in the order that they had. Returns
// for each vertex its number before.
std::vector<std::uint32_t> renumber_by_first_use(std::vector<mesh::Triangle>& triangles,
                                                 std::size_t vertex_count);

// Into the order that renumber_by_first_use() returns; empty values stay empty.
template <typename T>
void permute(std::vector<T>& values, const std::vector<std::uint32_t>& before) {
  if (values.empty()) return;
  std::vector<T> result(values.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = values[before[i]];
  values = std::move(result);
}

// How many vertices the triangles use, if these are in order of first use; else more or fewer. Indices must
// be in range.
inline std::size_t used_vertices(const std::vector<mesh::Triangle>& triangles, std::size_t vertex_count) {
  std::size_t used = 0;
  for (const mesh::Triangle& t : triangles) {
    const std::size_t first = t[0];
    const std::size_t second = t[1];
    const std::size_t third = t[2];
    // Apart from the number so far, so that one triangle need not wait for three steps of the one before.
    const std::size_t two = std::max(first, second) + 1;
    if (first > used || second > std::max(used, first + 1) || third > std::max(used, two))
      return vertex_count + 1;
    used = std::max(used, std::max(two, third + 1));
  }
  return used;
}

}  // namespace colossus::codec::coded
