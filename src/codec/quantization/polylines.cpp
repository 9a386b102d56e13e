#include "codec/quantization/polylines.hpp"

#include <algorithm>
#include <map>
#include <span>
#include <unordered_map>
#include <utility>

#include "codec/coded/places.hpp"
#include "mesh/topology.hpp"

namespace colossus::codec::quantization {
namespace {

using mesh::Triangle;

// The polyline of one face: border edges of the mesh within the face opposite `corner`, but for those along
// the face's own edges, which other faces share.
std::vector<mesh::Edge> polyline_of(std::span<const mesh::Edge> edges, std::size_t corner,
                                    const std::vector<coded::Weights>& weights) {
  std::vector<mesh::Edge> polyline;
  for (const mesh::Edge& edge : edges) {
    const coded::Weights& a = weights[edge.a];
    const coded::Weights& b = weights[edge.b];
    std::size_t common_faces = 0;
    for (std::size_t i = 0; i < 4; ++i) common_faces += a[i] == 0 && b[i] == 0 ? 1 : 0;
    if (a[corner] == 0 && b[corner] == 0 && common_faces == 1 && edge.forward != edge.backward)
      polyline.push_back(edge);
  }
  return polyline;
}

bool is_near(const coded::Weights& a, const coded::Weights& b) {
  constexpr std::uint32_t kMostUnits = 8;
  for (std::size_t i = 0; i < 4; ++i)
    if ((a[i] > b[i] ? a[i] - b[i] : b[i] - a[i]) > kMostUnits) return false;
  return true;
}

// Neighbours along a polyline, for vertices on no edge of the face that have two.
using Neighbors = std::map<std::uint32_t, std::vector<std::uint32_t>>;

Neighbors neighbors_along(const std::vector<mesh::Edge>& polyline,
                          const std::vector<coded::Weights>& weights) {
  Neighbors neighbors;
  for (const mesh::Edge& edge : polyline) {
    if (coded::face_count(weights[edge.a]) == 1) neighbors[edge.a].push_back(edge.b);
    if (coded::face_count(weights[edge.b]) == 1) neighbors[edge.b].push_back(edge.a);
  }
  std::erase_if(neighbors, [](const auto& entry) { return entry.second.size() != 2; });
  return neighbors;
}

// Where a polyline turns back on itself within a few units of weight, as around the cap of a spike, its
// turning points join their neighbours. All turns of a round at once, so that no order matters; a flattened
// turn can make the next one.
void flatten_turns(const Neighbors& neighbors, std::vector<coded::Weights>& weights) {
  constexpr int kMostRounds = 8;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<std::pair<std::uint32_t, coded::Weights>> moves;
    for (const auto& [v, ends] : neighbors)
      if (weights[ends[0]] == weights[ends[1]] && weights[ends[0]] != weights[v] &&
          is_near(weights[ends[0]], weights[v]))
        moves.emplace_back(v, weights[ends[0]]);
    if (moves.empty()) return;
    for (const auto& [v, to] : moves) weights[v] = to;
  }
}

// Where two edges of a face's polyline fall together, as where a thin sheet ends on the face, one end of one
// of them steps aside. Everything is done in the order of lattice positions, so that both sides do the same.
class PolylineSeparator {
 public:
  PolylineSeparator(mesh::Mesh& mesh, const std::vector<mesh::Edge>& polyline,
                    std::vector<coded::Weights>& weights)
      : mesh_(mesh), weights_(weights), polyline_(polyline) {}

  void separate() {
    constexpr int kMostRounds = 4;
    for (int round = 0; round < kMostRounds; ++round) {
      const ByPlace by_place = edges_by_place();
      if (by_place.empty()) return;
      if (round == 0) collect_places();
      bool has_moved = false;
      for (const auto& [place, edges] : by_place)
        has_moved |= separate_ends(edges, 0, place.first) || separate_ends(edges, 1, place.second);
      if (!has_moved) break;
    }
    for (auto& [place, edges] : edges_by_place()) split_all_but_one(edges);
  }

 private:
  using Ends = std::array<std::uint32_t, 2>;
  using ByPlace = std::map<std::pair<coded::Weights, coded::Weights>, std::vector<Ends>>;

  // Edges that fall together, by the weights of their ends.
  ByPlace edges_by_place() const {
    ByPlace by_place;
    for (const mesh::Edge& edge : polyline_) {
      const coded::Weights &a = weights_[edge.a], &b = weights_[edge.b];
      if (a < b) by_place[{a, b}].push_back({edge.a, edge.b});
      if (b < a) by_place[{b, a}].push_back({edge.b, edge.a});
    }
    std::erase_if(by_place, [](const auto& entry) { return entry.second.size() < 2; });
    return by_place;
  }

  void collect_places() {
    for (const mesh::Edge& edge : polyline_)
      for (const auto v : {edge.a, edge.b}) places_.try_emplace(weights_[v], v);
  }

  // Moves all but one of the vertices that still stand at `place`, an end of edges that have fallen together.
  bool separate_ends(const std::vector<Ends>& edges, std::size_t end, const coded::Weights& place) {
    std::vector<std::uint32_t> vertices;
    for (const Ends& ends : edges)
      if (weights_[ends[end]] == place) vertices.push_back(ends[end]);
    const auto may_move = [&](std::uint32_t v) { return coded::face_count(weights_[v]) == 1; };
    // First those that have to stay, if there are any.
    std::sort(vertices.begin(), vertices.end(),
              [&](auto a, auto b) { return may_move(a) != may_move(b) ? may_move(b) : is_before(a, b); });
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    bool has_moved = false;
    for (std::size_t i = 1; i < vertices.size(); ++i)
      if (may_move(vertices[i])) has_moved |= step_aside(vertices[i], weights_, places_);
    return has_moved;
  }

  // Where no end can move, as of a spike across an edge of the face, vertices in the middle must do.
  void split_all_but_one(std::vector<Ends> edges) {
    std::sort(edges.begin(), edges.end(), [&](const Ends& e, const Ends& f) {
      return e[0] != f[0] ? is_before(e[0], f[0]) : is_before(e[1], f[1]);
    });
    for (std::size_t i = 1; i < edges.size(); ++i) {
      const auto [a, b] = edges[i];
      const auto v = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(mesh::middle_of(mesh_.vertices[a], mesh_.vertices[b]));
      weights_.push_back(coded::middle_of(weights_[a], weights_[b]));
      if (!places_.try_emplace(weights_[v], v).second) step_aside(v, weights_, places_);
      split(a, b, v);
    }
  }

  // A border edge has one triangle.
  void split(std::uint32_t a, std::uint32_t b, std::uint32_t middle) {
    for (Triangle& t : mesh_.triangles) {
      const auto at_a = std::find(t.begin(), t.end(), a);
      const auto at_b = std::find(t.begin(), t.end(), b);
      if (at_a == t.end() || at_b == t.end()) continue;
      Triangle half = t;
      half[static_cast<std::size_t>(at_a - t.begin())] = middle;
      *at_b = middle;
      mesh_.triangles.push_back(half);
      return;
    }
  }

  bool is_before(std::uint32_t a, std::uint32_t b) const {
    return mesh_.vertices[a].position < mesh_.vertices[b].position;
  }

  mesh::Mesh& mesh_;
  std::vector<coded::Weights>& weights_;
  const std::vector<mesh::Edge>& polyline_;
  coded::Places places_;
};

}  // namespace

void settle_polylines(mesh::Mesh& mesh, std::vector<coded::Weights>& weights) {
  const auto is_in_face = [&](std::uint32_t a, std::uint32_t b) {
    return coded::share_face(weights[a], weights[b]);
  };
  std::vector<Triangle> at_faces;
  for (const Triangle& t : mesh.triangles)
    if (is_in_face(t[0], t[1]) || is_in_face(t[1], t[2]) || is_in_face(t[2], t[0])) at_faces.push_back(t);
  const std::vector<mesh::Edge> edges = mesh::edges(at_faces);
  // All before any is changed: a vertex that joins one on an edge of its face seems to be on two faces.
  std::array<std::vector<mesh::Edge>, 4> polylines;
  for (std::size_t corner = 0; corner < 4; ++corner) polylines[corner] = polyline_of(edges, corner, weights);
  for (const auto& polyline : polylines) {
    flatten_turns(neighbors_along(polyline, weights), weights);
    PolylineSeparator(mesh, polyline, weights).separate();
  }
}

}  // namespace colossus::codec::quantization
