#include "build/bucket_mesh.hpp"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "mesh/topology.hpp"

namespace colossus::build {

using core::ByteReader;
using core::Bytes;
using geometry::Point;

BucketMesh::BucketMesh(const Workspace& workspace, const VertexStore& store, const Cube& cube,
                       std::span<const scratch::RecordRef> records, const VertexStore* unrounded)
    : cube_(cube) {
  std::vector<BucketTriangle> triangles;
  for (const auto& record : records) {
    const Bytes bytes = workspace.reader.read(record);
    const auto part = ByteReader(bytes).get_array<BucketTriangle>(bytes.size() / sizeof(BucketTriangle));
    triangles.insert(triangles.end(), part.begin(), part.end());
  }
  index(triangles, store);
  std::vector<std::uint32_t> order;
  mesh::weld(mesh_, &order);
  drop_duplicates(triangles, order, unrounded);
  count_edges();
}

void BucketMesh::index(const std::vector<BucketTriangle>& triangles, const VertexStore& store) {
  std::unordered_map<std::uint64_t, std::uint32_t> local;
  local.reserve(triangles.size());
  mesh_.triangles.reserve(triangles.size());
  for (const BucketTriangle& t : triangles) {
    mesh::Triangle corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [entry, is_new] = local.try_emplace(t[k], static_cast<std::uint32_t>(mesh_.vertices.size()));
      if (is_new) mesh_.vertices.push_back(store[t[k]]);
      corners[k] = entry->second;
    }
    mesh_.triangles.push_back(corners);
  }
}

// Same positions in the same cyclic order: all but the first go. Each is counted in the one bucket that holds
// its least corner.
void BucketMesh::drop_duplicates(const std::vector<BucketTriangle>& triangles,
                                 const std::vector<std::uint32_t>& order, const VertexStore* unrounded) {
  const std::vector<std::uint32_t> first =
      mesh::first_with_same_corners(mesh_.triangles, mesh_.vertices.size());
  const auto was_same = [&](std::uint32_t i, std::uint32_t j) {
    if (unrounded == nullptr) return true;
    std::array<Point, 3> a, b;
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = (*unrounded)[triangles[order[i]][k]].position;
      b[k] = (*unrounded)[triangles[order[j]][k]].position;
    }
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    return a == b;
  };
  std::vector<bool> is_dropped(mesh_.triangles.size(), false);
  // Of each group the first triangle of either orientation stays.
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> groups;
  for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
    if (first[i] == i) continue;
    const mesh::Triangle& t = mesh_.triangles[i];
    auto& group = groups.try_emplace(first[i], 1, first[i]).first->second;
    const auto is_like = [&](std::uint32_t j) {
      return mesh::has_same_orientation(t, mesh_.triangles[j]) && was_same(i, j);
    };
    const auto is_opposite_by_rounding = [&](std::uint32_t j) {
      return !is_dropped[j] && !mesh::has_same_orientation(t, mesh_.triangles[j]) && !was_same(i, j);
    };
    if (std::any_of(group.begin(), group.end(), is_like)) {
      is_dropped[i] = true;
      const Point least = std::min({position(t[0]), position(t[1]), position(t[2])});
      if (cube_.contains(least)) ++duplicates_;
      continue;
    }
    const auto other = std::find_if(group.begin(), group.end(), is_opposite_by_rounding);
    if (other != group.end()) is_dropped[i] = is_dropped[*other] = true;
    group.push_back(i);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i)
    if (!is_dropped[i]) mesh_.triangles[kept++] = mesh_.triangles[i];
  mesh_.triangles.resize(kept);
}

// An edge is counted in the bucket that holds its lesser end: all triangles at it meet that cube.
void BucketMesh::count_edges() {
  for (const mesh::Edge& edge : mesh::edges(mesh_.triangles)) {
    if (!edge.is_border() && !edge.is_nonmanifold()) continue;
    if (!cube_.contains(std::min(position(edge.a), position(edge.b)))) continue;
    ++(edge.is_border() ? border_edges_ : nonmanifold_edges_);
  }
}

}  // namespace colossus::build
