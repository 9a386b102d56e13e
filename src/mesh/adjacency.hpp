// Triangles around each vertex, in compressed rows.
#pragma once

#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::mesh {

class Adjacency {
 public:
  // Reuses its memory from build to build. Linear.
  void build(std::span<const Triangle> triangles, std::size_t vertex_count) {
    offsets_.assign(vertex_count + 1, 0);
    for (const Triangle& t : triangles)
      for (const auto v : t) ++offsets_[v + 1];
    for (std::size_t v = 0; v < vertex_count; ++v) offsets_[v + 1] += offsets_[v];
    triangles_.resize(triangles.size() * 3);
    cursor_.assign(offsets_.begin(), offsets_.end() - 1);
    for (std::uint32_t i = 0; i < triangles.size(); ++i)
      for (const auto v : triangles[i]) triangles_[cursor_[v]++] = i;
  }
  std::span<const std::uint32_t> around(std::uint32_t vertex) const {
    return std::span<const std::uint32_t>(triangles_)
        .subspan(offsets_[vertex], offsets_[vertex + 1] - offsets_[vertex]);
  }

 private:
  std::vector<std::uint32_t> offsets_;
  std::vector<std::uint32_t> cursor_;
  std::vector<std::uint32_t> triangles_;
};

}  // namespace colossus::mesh
