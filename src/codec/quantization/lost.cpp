#include "codec/quantization/lost.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "codec/coded/places.hpp"
#include "geometry/vector.hpp"

namespace colossus::codec::quantization {
namespace {

using geometry::Vec3;
using mesh::Triangle;
using Segment = std::pair<std::uint32_t, std::uint32_t>;  // vertices, the lesser first

Segment segment_of(const Triangle& t, const std::vector<std::uint32_t>& welded) {
  const auto [least, most] = std::minmax({welded[t[0]], welded[t[1]], welded[t[2]]});
  return {least, most};
}

// Two opposite triangles.
struct Pair {
  std::array<std::size_t, 2> triangles;
  Segment longest;  // edge
  double height = 0.0;
};

class PairFinder {
 public:
  PairFinder(const hierarchy::Tetrahedron& tetrahedron, int position_bits,
             const std::vector<coded::Weights>& weights, const std::vector<Triangle>& triangles)
      : tetrahedron_(tetrahedron),
        scale_(1.0 / static_cast<double>(std::int64_t{1} << position_bits)),
        weights_(weights),
        triangles_(triangles) {}

  std::vector<Pair> run() const {
    std::vector<Pair> pairs;
    for (const auto& group : groups()) {
      std::array<std::vector<std::size_t>, 2> sides;
      for (const std::size_t i : group)
        sides[mesh::has_same_orientation(triangles_[i], triangles_[group[0]]) ? 0 : 1].push_back(i);
      for (std::size_t k = 0; k < std::min(sides[0].size(), sides[1].size()); ++k)
        pairs.push_back(pair_of(sides[0][k], sides[1][k]));
    }
    return pairs;
  }

  // Lattice units.
  double unit() const {
    std::int64_t squared = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        squared =
            std::max(squared, geometry::squared_distance(tetrahedron_.corners[i], tetrahedron_.corners[j]));
    return scale_ * std::sqrt(static_cast<double>(squared));
  }

 private:
  // Triangles over the same vertices, where there are several.
  std::vector<std::vector<std::size_t>> groups() const {
    const std::vector<std::uint32_t> first = mesh::first_with_same_corners(triangles_, weights_.size());
    std::map<std::uint32_t, std::vector<std::size_t>> by_first;
    for (std::size_t i = 0; i < first.size(); ++i)
      if (first[i] != i) by_first.try_emplace(first[i], 1, first[i]).first->second.push_back(i);
    std::vector<std::vector<std::size_t>> groups;
    groups.reserve(by_first.size());
    for (auto& [i, group] : by_first) groups.push_back(std::move(group));
    return groups;
  }

  Vec3 at(std::uint32_t v) const {
    const coded::ScaledPosition p = coded::scaled_position(weights_[v], tetrahedron_);
    return {scale_ * static_cast<double>(p[0]), scale_ * static_cast<double>(p[1]),
            scale_ * static_cast<double>(p[2])};
  }

  Pair pair_of(std::size_t one, std::size_t other) const {
    const Triangle& t = triangles_[one];
    std::size_t longest = 0;
    std::array<double, 3> squares{};
    for (std::size_t k = 0; k < 3; ++k) {
      squares[k] = geometry::squared_length(at(t[(k + 1) % 3]) - at(t[k]));
      if (squares[k] > squares[longest]) longest = k;
    }
    const double doubled = geometry::length(geometry::cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0])));
    return {
        {one, other}, std::minmax(t[longest], t[(longest + 1) % 3]), doubled / std::sqrt(squares[longest])};
  }

  const hierarchy::Tetrahedron& tetrahedron_;
  double scale_;
  const std::vector<coded::Weights>& weights_;
  const std::vector<Triangle>& triangles_;
};

}  // namespace

double take_out_pairs(const hierarchy::Tetrahedron& tetrahedron, int position_bits,
                      const std::vector<coded::Weights>& weights, std::vector<Triangle>& triangles,
                      std::vector<Triangle>& to_revive) {
  const PairFinder finder(tetrahedron, position_bits, weights, triangles);
  const std::vector<Pair> pairs = finder.run();
  if (pairs.empty()) return 0.0;
  std::vector<bool> is_in_pair(triangles.size(), false);
  std::map<Segment, bool> goes_on;  // by longest edge
  for (const Pair& pair : pairs) {
    is_in_pair[pair.triangles[0]] = is_in_pair[pair.triangles[1]] = true;
    goes_on.try_emplace(pair.longest, false);
  }
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3 && !is_in_pair[i]; ++k)
      if (const auto edge = goes_on.find(std::minmax(triangles[i][k], triangles[i][(k + 1) % 3]));
          edge != goes_on.end())
        edge->second = true;
  double widest = 0.0;
  for (const Pair& pair : pairs) {
    if (pair.height <= finder.unit() && goes_on[pair.longest])
      widest = std::max(widest, pair.height);
    else
      to_revive.push_back(triangles[pair.triangles[0]]);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (!is_in_pair[i]) triangles[kept++] = triangles[i];
  triangles.resize(kept);
  return widest;
}

std::vector<Triangle> uncovered(const std::vector<Triangle>& lost, const std::vector<std::uint32_t>& welded,
                                const std::vector<Triangle>& triangles) {
  std::map<Segment, Triangle> by_segment;
  std::vector<bool> is_end(welded.size(), false), is_corner(welded.size(), false);
  for (const Triangle& t : lost) {
    const Segment segment = segment_of(t, welded);
    by_segment.try_emplace(segment, t);
    is_end[segment.first] = is_end[segment.second] = true;
  }
  if (by_segment.empty()) return {};
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = welded[t[k]], b = welded[t[(k + 1) % 3]];
      if (!is_end[a]) continue;
      is_corner[a] = true;
      by_segment.erase(std::minmax(a, b));
      by_segment.erase(std::minmax(a, welded[t[(k + 2) % 3]]));
    }
  for (const auto& [segment, t] : by_segment)
    if (segment.first != segment.second) is_corner[segment.first] = is_corner[segment.second] = true;
  std::vector<Triangle> result;
  for (const auto& [segment, t] : by_segment)
    if (segment.first != segment.second || !is_corner[segment.first]) result.push_back(t);
  return result;
}

std::vector<std::uint32_t> revive(const std::vector<Triangle>& to_revive, std::vector<mesh::Vertex>& vertices,
                                  std::vector<Triangle>& triangles, std::vector<coded::Weights>& weights) {
  std::vector<std::uint32_t> copied;
  if (to_revive.empty()) return copied;
  coded::Places places;
  for (std::uint32_t v = 0; v < weights.size(); ++v) places.try_emplace(weights[v], v);
  const auto add = [&](std::uint32_t like) {
    const auto v = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(mesh::Vertex(vertices[like]));
    weights.push_back(coded::off_faces(weights[like]));
    if (!places.try_emplace(weights[v], v).second) step_aside(v, weights, places);
    copied.push_back(like);
    return v;
  };
  for (const Triangle& t : to_revive) {
    const Triangle pair{add(t[0]), add(t[1]), add(t[2])};
    triangles.push_back(pair);
    triangles.push_back({pair[0], pair[2], pair[1]});
  }
  return copied;
}

}  // namespace colossus::codec::quantization
