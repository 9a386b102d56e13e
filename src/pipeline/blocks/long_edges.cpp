#include "pipeline/blocks/long_edges.hpp"

#include <algorithm>

#include "hierarchy/octree.hpp"

namespace colossus::pipeline::blocks {

using geometry::Point;

Point middle_on_grid(const Point& a, const Point& b, std::int32_t spacing) {
  Point middle;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t sum = (std::int64_t{a[axis]} + b[axis]) / spacing;
    const std::int64_t lower = sum / 2;
    middle[axis] = static_cast<std::int32_t>((lower + (sum & lower & 1)) * spacing);
  }
  return middle;
}

LongEdgeSplitter::LongEdgeSplitter(std::int64_t longest, std::int32_t spacing, mesh::Mesh& mesh)
    : longest_(longest), spacing_(spacing), mesh_(mesh), part_of_(mesh.triangles.size(), kNone) {}

std::uint64_t LongEdgeSplitter::run(const hierarchy::CubeId& cube) {
  while (split_once(cube)) {
  }
  split_lost();
  return count_;
}

// Like the edges of the triangles beside them.
void LongEdgeSplitter::split_lost() {
  std::vector<buckets::LostTriangle> pending = std::move(lost_);
  lost_.clear();
  while (!pending.empty()) {
    const buckets::LostTriangle lost = pending.back();
    pending.pop_back();
    const mesh::Vertex& a = lost.corners[0];
    const mesh::Vertex& b = lost.corners[1].position != a.position ? lost.corners[1] : lost.corners[2];
    if (hierarchy::max_distance(a.position, b.position) <= longest_) {
      lost_.push_back(lost);
      continue;
    }
    mesh::Vertex middle = mesh::interpolate(a, b, 1, 2);
    middle.position = middle_on_grid(a.position, b.position, spacing_);
    pending.push_back({{a, middle, middle}, 0.0});
    pending.push_back({{middle, b, b}, 0.0});
  }
}

double LongEdgeSplitter::displacement(std::uint32_t triangle) const {
  // Those added since are nobody's parts.
  if (triangle >= part_of_.size() || part_of_[triangle] == kNone) return 0.0;
  const Corners& corners = parts_[part_of_[triangle]];
  double farthest = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    farthest = std::max(farthest,
                        geometry::length(geometry::to_vec3(at(mesh_.triangles[triangle][k])) - corners[k]));
  return farthest;
}

LongEdgeSplitter::Corners LongEdgeSplitter::corners_of(std::uint32_t triangle) const {
  if (part_of_[triangle] != kNone) return parts_[part_of_[triangle]];
  const mesh::Triangle& t = mesh_.triangles[triangle];
  return {geometry::to_vec3(at(t[0])), geometry::to_vec3(at(t[1])), geometry::to_vec3(at(t[2]))};
}

bool LongEdgeSplitter::split_once(const hierarchy::CubeId& cube) {
  std::vector<mesh::Triangle> triangles;
  std::vector<std::uint32_t> part_of;
  std::vector<Corners> parts;
  middles_.clear();
  for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
    const mesh::Triangle t = mesh_.triangles[i];
    std::array<std::uint32_t, 3> middle{kNone, kNone, kNone};
    bool is_split = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (hierarchy::max_distance(at(a), at(b)) <= longest_) continue;
      middle[k] = middle_of(a, b, cube);
      is_split = true;
    }
    if (!is_split && part_of_[i] == kNone) {
      triangles.push_back(t);
      part_of.push_back(kNone);
      continue;
    }
    auto part = static_cast<std::uint32_t>(parts.size());
    divide(t, corners_of(i), middle, triangles, parts);
    while (part < parts.size()) part_of.push_back(part++);
  }
  if (middles_.empty()) return false;
  for (const mesh::Triangle& t : triangles)
    if (mesh::is_degenerate(at(t[0]), at(t[1]), at(t[2])))
      lost_.push_back({{mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]}, 0.0});
  mesh_.triangles = std::move(triangles);
  parts_ = std::move(parts);
  std::vector<std::uint32_t> order;
  mesh::weld(mesh_, &order);
  part_of_.clear();
  for (const auto i : order) part_of_.push_back(part_of[i]);
  return true;
}

std::uint32_t LongEdgeSplitter::middle_of(std::uint32_t a, std::uint32_t b, const hierarchy::CubeId& cube) {
  const auto [entry, is_new] =
      middles_.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh_.vertices.size()));
  if (!is_new) return entry->second;
  // Halfway the order of the ends does not matter.
  mesh::Vertex middle = mesh::interpolate(mesh_.vertices[a], mesh_.vertices[b], 1, 2);
  middle.position = middle_on_grid(at(a), at(b), spacing_);
  if (cube.contains(std::min(at(a), at(b)), geometry::kRootBits)) ++count_;
  mesh_.vertices.push_back(middle);
  return entry->second;
}

// middle[k] is that of the edge from corner k.
void LongEdgeSplitter::divide(const mesh::Triangle& t, const Corners& corners,
                              const std::array<std::uint32_t, 3>& middle,
                              std::vector<mesh::Triangle>& triangles, std::vector<Corners>& parts) const {
  const auto add = [&](std::initializer_list<std::size_t> places) {
    // 0 to 2 are corners, 3 to 5 the middles of the edges from them.
    mesh::Triangle& triangle = triangles.emplace_back();
    Corners& part = parts.emplace_back();
    std::size_t k = 0;
    for (const std::size_t place : places) {
      const std::size_t corner = place % 3;
      triangle[k] = place < 3 ? t[corner] : middle[corner];
      part[k++] = place < 3 ? corners[corner] : 0.5 * (corners[corner] + corners[(corner + 1) % 3]);
    }
  };
  const auto count = std::count_if(middle.begin(), middle.end(), [](auto m) { return m != kNone; });
  if (count == 0) {
    add({0, 1, 2});
  } else if (count == 3) {
    for (std::size_t k = 0; k < 3; ++k) add({k, k + 3, (k + 2) % 3 + 3});
    add({3, 4, 5});
  } else {
    // Turned so that the first edge is split, and the last is not.
    std::size_t a = 0;
    while (middle[a] == kNone || middle[(a + 2) % 3] != kNone) ++a;
    const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
    if (count == 1) {
      add({a, a + 3, c});
      add({a + 3, b, c});
    } else {
      add({a + 3, b, b + 3});
      add({a, a + 3, b + 3});
      add({a, b + 3, c});
    }
  }
}

}  // namespace colossus::pipeline::blocks
