#include "codec/quantization/pinches.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "codec/coded/places.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/topology.hpp"

namespace colossus::codec::quantization {
namespace {

using mesh::Triangle;

bool has_vertex(const Triangle& t, std::uint32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

// Whether the triangle has the edge from `a` to `b` in this direction, of those that have both.
bool goes_along(const Triangle& t, std::uint32_t a, std::uint32_t b) {
  return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
}

// The welded edges of more than two triangles, and what they are made of.
class PinchedEdges {
 public:
  PinchedEdges(const std::vector<Triangle>& triangles, const std::vector<coded::Weights>& weights,
               std::vector<bool> is_shared) {
    std::vector<std::uint32_t> welded(weights.size(), 0);
    bool has_pinch = std::find(is_shared.begin(), is_shared.end(), true) != is_shared.end();
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

  coded::Places places;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<mesh::Edge>> by_place;
};

// Splits edges while it keeps track of the triangles around their ends.
class EdgeSplitter {
 public:
  EdgeSplitter(std::vector<Triangle>& triangles, std::size_t vertex_count) : triangles_(triangles) {
    around_.build(triangles, vertex_count);
  }

  // Of the triangles at the edge, splits one of each direction, so that these two share the new halves.
  void split_pair(const mesh::Edge& edge, std::uint32_t middle) {
    bool needs_forward = true, needs_backward = true;
    const auto before = around_.around(edge.a);
    std::vector<std::uint32_t> candidates(before.begin(), before.end());
    const auto& later = added_[edge.a];
    candidates.insert(candidates.end(), later.begin(), later.end());
    for (const auto i : candidates) {
      if (!has_vertex(triangles_[i], edge.a) || !has_vertex(triangles_[i], edge.b)) continue;
      bool& is_needed = goes_along(triangles_[i], edge.a, edge.b) ? needs_forward : needs_backward;
      if (!std::exchange(is_needed, false)) continue;
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

}  // namespace

void separate_edges(const std::vector<Triangle>& triangles, std::vector<coded::Weights>& weights) {
  std::vector<std::uint32_t> welded(weights.size());
  std::vector<bool> is_used(weights.size(), false);
  for (const Triangle& t : triangles)
    for (const auto v : t) is_used[v] = true;
  for (int round = 0; round < 4; ++round) {
    coded::Places places;
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
      const bool is_inner = coded::face_count(weights[v]) == 0;
      if (is_used[v] && is_inner && is_shared[v] && pinched.contains(welded[v]) &&
          (welded[v] != v || round > 0))
        has_moved |= step_aside(v, weights, places);
    }
    if (!has_moved) return;
  }
}

void split_edges(std::vector<mesh::Vertex>& vertices, std::vector<Triangle>& triangles,
                 std::vector<coded::Weights>& weights, const std::vector<bool>& is_merged) {
  PinchedEdges pinched(triangles, weights, is_merged);
  if (pinched.by_place.empty()) return;
  EdgeSplitter splitter(triangles, weights.size());
  for (const auto& [place, edges] : pinched.by_place) {
    // One pair of triangles may stay: one that cannot be split, if there is any.
    const auto is_balanced = [](const mesh::Edge& edge) { return edge.forward == edge.backward; };
    bool may_stay = std::all_of(edges.begin(), edges.end(), is_balanced);
    for (const mesh::Edge& edge : edges) {
      // Without its pairs, the triangle that is left of an edge inside, where three sheets of the input meet,
      // would end in a crack.
      if (!is_balanced(edge) && !coded::share_face(weights[edge.a], weights[edge.b])) continue;
      for (std::uint32_t pair = 0; pair < std::min(edge.forward, edge.backward); ++pair) {
        if (std::exchange(may_stay, false)) continue;
        // On no face, or neighbours would have to know it.
        const coded::Weights middle = coded::off_faces(coded::middle_of(weights[edge.a], weights[edge.b]));
        const auto v = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(mesh::middle_of(vertices[edge.a], vertices[edge.b]));
        weights.push_back(middle);
        if (!pinched.places.try_emplace(middle, v).second) step_aside(v, weights, pinched.places);
        splitter.split_pair(edge, v);
      }
    }
  }
}

}  // namespace colossus::codec::quantization
