#include "codec/pinches.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/hash.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/topology.hpp"

namespace colossus::codec {
namespace {

using mesh::Triangle;

struct WeightsHash {
  std::size_t operator()(const Weights& w) const {
    return core::mix64((std::uint64_t{w[0]} << 32 | w[1]) ^ core::mix64(w[2] + 0x9e3779b97f4a7c15ULL));
  }
};

using Places = std::unordered_map<Weights, std::uint32_t, WeightsHash>;

// Moves a vertex by one step to a place that none of `places` is; weights that are 0 stay 0, and no others
// become 0. False when there is no such place.
bool step_aside(std::uint32_t v, std::vector<Weights>& weights, Places& places) {
  for (std::size_t to = 0; to < 4; ++to)
    for (std::size_t from = 0; from < 4; ++from) {
      Weights moved = weights[v];
      if (to == from || moved[from] < 2 || moved[to] == 0) continue;
      ++moved[to];
      --moved[from];
      if (!places.try_emplace(moved, v).second) continue;
      weights[v] = moved;
      return true;
    }
  return false;
}

std::size_t face_count(const Weights& weights) {
  return static_cast<std::size_t>(std::count(weights.begin(), weights.end(), 0U));
}

bool has_vertex(const Triangle& t, std::uint32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

// The welded edges of more than two triangles, and what they are made of.
class PinchedEdges {
 public:
  PinchedEdges(const std::vector<Triangle>& triangles, const std::vector<Weights>& weights) {
    std::vector<std::uint32_t> welded(weights.size(), 0);
    std::vector<bool> is_shared(weights.size(), false);
    bool has_pinch = false;
    for (const Triangle& t : triangles)
      for (const auto v : t) {
        const auto [entry, is_new] = places.try_emplace(weights[v], v);
        welded[v] = entry->second;
        if (entry->second != v) is_shared[v] = is_shared[entry->second] = has_pinch = true;
      }
    if (!has_pinch) return;
    std::vector<Triangle> around;
    for (const Triangle& t : triangles)
      if (is_shared[t[0]] || is_shared[t[1]] || is_shared[t[2]]) around.push_back(t);
    std::vector<Triangle> around_welded = around;
    for (Triangle& t : around_welded)
      for (auto& v : t) v = welded[v];
    std::set<std::pair<std::uint32_t, std::uint32_t>> pinched;
    for (const mesh::Edge& edge : mesh::edges(around_welded))
      if (edge.is_nonmanifold()) pinched.emplace(edge.a, edge.b);
    for (const mesh::Edge& edge : mesh::edges(around)) {
      const auto place = std::minmax(welded[edge.a], welded[edge.b]);
      if (pinched.contains({place.first, place.second}))
        by_place[{place.first, place.second}].push_back(edge);
    }
  }

  Places places;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<mesh::Edge>> by_place;
};

// Halfway between two places, on no face that they do not share.
Weights middle_of(const Weights& a, const Weights& b) {
  Weights middle{};
  bool rounds_up = false;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint32_t sum = a[i] + b[i];
    middle[i] = sum / 2;
    if (sum % 2 == 0) continue;
    middle[i] += rounds_up ? 1 : 0;
    rounds_up = !rounds_up;
  }
  for (std::size_t i = 0; i < 4; ++i)
    if (middle[i] == 0 && a[i] + b[i] > 0) {
      --*std::max_element(middle.begin(), middle.end());
      middle[i] = 1;
    }
  return middle;
}

// Splits edges while it keeps track of the triangles around their ends.
class EdgeSplitter {
 public:
  EdgeSplitter(std::vector<Triangle>& triangles, std::size_t vertex_count) : triangles_(triangles) {
    around_.build(triangles, vertex_count);
  }

  void split(const mesh::Edge& edge, std::uint32_t middle) {
    const auto before = around_.around(edge.a);
    std::vector<std::uint32_t> candidates(before.begin(), before.end());
    const auto& later = added_[edge.a];
    candidates.insert(candidates.end(), later.begin(), later.end());
    for (const auto i : candidates) {
      if (!has_vertex(triangles_[i], edge.a) || !has_vertex(triangles_[i], edge.b)) continue;
      Triangle half = triangles_[i];
      std::replace(half.begin(), half.end(), edge.a, middle);
      std::replace(triangles_[i].begin(), triangles_[i].end(), edge.b, middle);
      for (const auto v : half) added_[v].push_back(static_cast<std::uint32_t>(triangles_.size()));
      triangles_.push_back(half);
    }
  }

 private:
  std::vector<Triangle>& triangles_;
  mesh::Adjacency around_;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> added_;
};

// Neighbours along the polyline of a face, for vertices within the face and on none of its edges that have
// two.
using Neighbors = std::map<std::uint32_t, std::vector<std::uint32_t>>;

// Border edges of the mesh within the face opposite `corner`, but for those along its edges, which other
// faces share.
Neighbors polyline_of(std::span<const mesh::Edge> edges, std::size_t corner,
                      const std::vector<Weights>& weights) {
  Neighbors neighbors;
  for (const mesh::Edge& edge : edges) {
    const Weights& a = weights[edge.a];
    const Weights& b = weights[edge.b];
    std::size_t common_faces = 0;
    for (std::size_t i = 0; i < 4; ++i) common_faces += a[i] == 0 && b[i] == 0 ? 1 : 0;
    if (a[corner] != 0 || b[corner] != 0 || common_faces != 1 || edge.forward == edge.backward) continue;
    if (face_count(a) == 1) neighbors[edge.a].push_back(edge.b);
    if (face_count(b) == 1) neighbors[edge.b].push_back(edge.a);
  }
  std::erase_if(neighbors, [](const auto& entry) { return entry.second.size() != 2; });
  return neighbors;
}

bool is_near(const Weights& a, const Weights& b) {
  constexpr std::uint32_t kMostUnits = 8;
  for (std::size_t i = 0; i < 4; ++i)
    if ((a[i] > b[i] ? a[i] - b[i] : b[i] - a[i]) > kMostUnits) return false;
  return true;
}

}  // namespace

void flatten_turns(const mesh::Mesh& mesh, std::vector<Weights>& weights) {
  const auto share_face = [&](std::uint32_t a, std::uint32_t b) {
    for (std::size_t corner = 0; corner < 4; ++corner)
      if (weights[a][corner] == 0 && weights[b][corner] == 0) return true;
    return false;
  };
  std::vector<Triangle> at_faces;
  for (const Triangle& t : mesh.triangles)
    if (share_face(t[0], t[1]) || share_face(t[1], t[2]) || share_face(t[2], t[0])) at_faces.push_back(t);
  const std::vector<mesh::Edge> edges = mesh::edges(at_faces);
  std::array<Neighbors, 4> polylines;
  for (std::size_t corner = 0; corner < 4; ++corner) polylines[corner] = polyline_of(edges, corner, weights);
  // All turns of a round at once, so that no order matters; a flattened turn can make the next one.
  constexpr int kMostRounds = 8;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<std::pair<std::uint32_t, Weights>> moves;
    for (const Neighbors& polyline : polylines)
      for (const auto& [v, ends] : polyline)
        if (weights[ends[0]] == weights[ends[1]] && weights[ends[0]] != weights[v] &&
            is_near(weights[ends[0]], weights[v]))
          moves.emplace_back(v, weights[ends[0]]);
    if (moves.empty()) return;
    for (const auto& [v, to] : moves) weights[v] = to;
  }
}

void separate_edges(const std::vector<Triangle>& triangles, std::vector<Weights>& weights) {
  std::vector<std::uint32_t> welded(weights.size());
  std::vector<bool> is_used(weights.size(), false);
  for (const Triangle& t : triangles)
    for (const auto v : t) is_used[v] = true;
  for (int round = 0; round < 4; ++round) {
    Places places;
    places.reserve(weights.size());
    std::vector<bool> is_shared(weights.size(), false);
    bool has_pinch = false;
    for (std::uint32_t v = 0; v < weights.size(); ++v) {
      if (!is_used[v]) continue;
      const auto [entry, is_new] = places.try_emplace(weights[v], v);
      welded[v] = entry->second;
      if (!is_new) is_shared[v] = is_shared[entry->second] = has_pinch = true;
    }
    if (!has_pinch) return;
    // Only edges with an end at a shared place can have fallen together.
    std::vector<Triangle> around_welded;
    for (const Triangle& t : triangles) {
      if (!is_shared[t[0]] && !is_shared[t[1]] && !is_shared[t[2]]) continue;
      around_welded.push_back({welded[t[0]], welded[t[1]], welded[t[2]]});
    }
    std::unordered_set<std::uint32_t> pinched;
    for (const mesh::Edge& edge : mesh::edges(around_welded))
      if (edge.is_nonmanifold())
        for (const auto end : {edge.a, edge.b})
          if (is_shared[end]) pinched.insert(end);
    bool has_moved = false;
    for (std::uint32_t v = 0; v < weights.size() && !pinched.empty(); ++v) {
      const bool is_inner = face_count(weights[v]) == 0;
      if (is_used[v] && is_inner && is_shared[v] && pinched.contains(welded[v]) &&
          (welded[v] != v || round > 0))
        has_moved |= step_aside(v, weights, places);
    }
    if (!has_moved) return;
  }
}

void split_edges(std::vector<mesh::Vertex>& vertices, std::vector<Triangle>& triangles,
                 std::vector<Weights>& weights) {
  PinchedEdges pinched(triangles, weights);
  if (pinched.by_place.empty()) return;
  EdgeSplitter splitter(triangles, weights.size());
  for (const auto& [place, edges] : pinched.by_place) {
    // One of them may stay: one that cannot be split, if there is any.
    const auto can_split = [&](const mesh::Edge& edge) {
      return edge.count() == 2 && face_count(middle_of(weights[edge.a], weights[edge.b])) == 0;
    };
    bool may_stay = std::all_of(edges.begin(), edges.end(), can_split);
    for (const mesh::Edge& edge : edges) {
      if (!can_split(edge) || std::exchange(may_stay, false)) continue;
      const Weights middle = middle_of(weights[edge.a], weights[edge.b]);
      const auto v = static_cast<std::uint32_t>(vertices.size());
      const mesh::Vertex& a = vertices[edge.a];
      const mesh::Vertex& b = vertices[edge.b];
      mesh::Vertex between = mesh::interpolate(a, b, 1, 2);
      for (int axis = 0; axis < 3; ++axis)
        between.position[axis] =
            static_cast<std::int32_t>((std::int64_t{a.position[axis]} + b.position[axis]) / 2);
      weights.push_back(middle);
      vertices.push_back(between);
      if (!pinched.places.try_emplace(middle, v).second) step_aside(v, weights, pinched.places);
      splitter.split(edge, v);
    }
  }
}

}  // namespace colossus::codec
