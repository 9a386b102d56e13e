#include "codec/pinches.hpp"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "core/hash.hpp"
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

// Moves a vertex by one step to a place that none of `places` is; weights that are 0 stay 0, and no others become 0.
// False when there is no such place.
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

// Two polyline edges on the face opposite `corner` that fall together: their vertices step aside within the face, in
// an order that both sides of the face know.
void separate_on_face(const mesh::Mesh& mesh, std::span<const mesh::Edge> edges, std::size_t corner,
                      std::vector<Weights>& weights) {
  std::vector<std::pair<Weights, Weights>> places_of_edges;
  std::vector<std::uint32_t> vertices;
  for (const mesh::Edge& edge : edges) {
    if (weights[edge.a][corner] != 0 || weights[edge.b][corner] != 0 || edge.forward == edge.backward) continue;
    places_of_edges.push_back(std::minmax(weights[edge.a], weights[edge.b]));
    vertices.push_back(edge.a);
    vertices.push_back(edge.b);
  }
  std::sort(places_of_edges.begin(), places_of_edges.end());
  std::unordered_set<Weights, WeightsHash> pinched;
  for (std::size_t i = 1; i < places_of_edges.size(); ++i)
    if (places_of_edges[i] == places_of_edges[i - 1] && places_of_edges[i].first != places_of_edges[i].second) {
      pinched.insert(places_of_edges[i].first);
      pinched.insert(places_of_edges[i].second);
    }
  if (pinched.empty()) return;
  const auto position = [&](std::uint32_t v) { return mesh.vertices[v].position; };
  std::sort(vertices.begin(), vertices.end(), [&](auto a, auto b) { return position(a) < position(b); });
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  Places places;
  for (const auto v : vertices) places.try_emplace(weights[v], v);
  for (const auto v : vertices) {
    const bool is_first = places.at(weights[v]) == v;
    if (!is_first && face_count(weights[v]) == 1 && pinched.contains(weights[v])) step_aside(v, weights, places);
  }
}

// Vertices on the edges of the tetrahedron, which all tetrahedra around such an edge have in common, always keep apart:
// on a face that is not theirs to decide.
void separate_on_edges(const mesh::Mesh& mesh, std::vector<Weights>& weights) {
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < weights.size(); ++v)
    if (face_count(weights[v]) == 2) vertices.push_back(v);
  std::sort(vertices.begin(), vertices.end(),
            [&](auto a, auto b) { return mesh.vertices[a].position < mesh.vertices[b].position; });
  Places places;
  for (const auto v : vertices)
    if (!places.try_emplace(weights[v], v).second) step_aside(v, weights, places);
}

}  // namespace

void separate_polylines(const mesh::Mesh& mesh, std::vector<Weights>& weights) {
  const auto share_face = [&](std::uint32_t a, std::uint32_t b) {
    for (std::size_t corner = 0; corner < 4; ++corner)
      if (weights[a][corner] == 0 && weights[b][corner] == 0) return true;
    return false;
  };
  std::vector<Triangle> at_faces;
  for (const Triangle& t : mesh.triangles)
    if (share_face(t[0], t[1]) || share_face(t[1], t[2]) || share_face(t[2], t[0])) at_faces.push_back(t);
  const std::vector<mesh::Edge> edges = mesh::edges(at_faces);
  separate_on_edges(mesh, weights);
  for (std::size_t corner = 0; corner < 4; ++corner) separate_on_face(mesh, edges, corner, weights);
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
      if (is_used[v] && is_inner && is_shared[v] && pinched.contains(welded[v]) && (welded[v] != v || round > 0))
        has_moved |= step_aside(v, weights, places);
    }
    if (!has_moved) return;
  }
}

}  // namespace colossus::codec
