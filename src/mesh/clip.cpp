#include "mesh/clip.hpp"

#include <algorithm>
#include <cstdlib>
#include <unordered_map>

namespace colossus::mesh {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

class Splitter {
 public:
  Splitter(const Mesh& mesh, const geometry::Plane& plane) : mesh_(mesh) {
    sides_.reserve(mesh.vertices.size());
    for (const Vertex& v : mesh.vertices) sides_.push_back(plane.side(v.position));
    for (auto& map : renumbered_) map.assign(mesh.vertices.size(), kNone);
  }

  std::array<Mesh, 2> run() {
    for (const Triangle& t : mesh_.triangles) {
      const int above = (sides_[t[0]] > 0) + (sides_[t[1]] > 0) + (sides_[t[2]] > 0);
      const int below = (sides_[t[0]] < 0) + (sides_[t[1]] < 0) + (sides_[t[2]] < 0);
      if (below == 0)
        emit(0, {kept(0, t[0]), kept(0, t[1]), kept(0, t[2])});
      else if (above == 0)
        emit(1, {kept(1, t[0]), kept(1, t[1]), kept(1, t[2])});
      else if (above + below == 2)
        cut_through_corner(t);
      else
        cut_two_edges(t, above == 1 ? 0 : 1);
    }
    return std::move(halves_);
  }

 private:
  std::uint32_t kept(std::size_t half, std::uint32_t v) {
    std::uint32_t& index = renumbered_[half][v];
    if (index == kNone) index = add(half, mesh_.vertices[v]);
    return index;
  }

  std::uint32_t add(std::size_t half, const Vertex& v) {
    halves_[half].vertices.push_back(v);
    return static_cast<std::uint32_t>(halves_[half].vertices.size() - 1);
  }

  // The cut of an edge, as a vertex of each half.
  std::array<std::uint32_t, 2> cut(std::uint32_t a, std::uint32_t b) {
    if (mesh_.vertices[b].position < mesh_.vertices[a].position) std::swap(a, b);
    const auto [entry, is_new] = cuts_.try_emplace(std::uint64_t{a} << 32 | b);
    if (is_new) {
      const Vertex& p = mesh_.vertices[a];
      const Vertex& q = mesh_.vertices[b];
      const std::int64_t to_plane = std::abs(sides_[a]);
      Vertex v = interpolate(p, q, to_plane, to_plane + std::abs(sides_[b]));
      v.position = geometry::cut_edge(p.position, q.position, sides_[a], sides_[b]);
      entry->second = {add(0, v), add(1, v)};
    }
    return entry->second;
  }

  void emit(std::size_t half, const Triangle& t) {
    const auto& v = halves_[half].vertices;
    if (v[t[0]].position != v[t[1]].position || v[t[1]].position != v[t[2]].position)
      halves_[half].triangles.push_back(t);
  }

  // One corner on the plane, one on each side.
  void cut_through_corner(const Triangle& t) {
    const std::size_t k = sides_[t[0]] == 0 ? 0 : sides_[t[1]] == 0 ? 1 : 2;
    const std::uint32_t on = t[k];
    const std::uint32_t next = t[(k + 1) % 3];
    const std::uint32_t last = t[(k + 2) % 3];
    const auto point = cut(next, last);
    const std::size_t half = sides_[next] > 0 ? 0 : 1;
    emit(half, {kept(half, on), kept(half, next), point[half]});
    emit(1 - half, {kept(1 - half, on), point[1 - half], kept(1 - half, last)});
  }

  // One corner, on the side `half`, is alone.
  void cut_two_edges(const Triangle& t, std::size_t half) {
    const auto is_alone = [&](std::uint32_t v) { return half == 0 ? sides_[v] > 0 : sides_[v] < 0; };
    const std::size_t k = is_alone(t[0]) ? 0 : is_alone(t[1]) ? 1 : 2;
    const std::uint32_t next = t[(k + 1) % 3];
    const std::uint32_t last = t[(k + 2) % 3];
    const auto to_next = cut(t[k], next);
    const auto to_last = cut(t[k], last);
    emit(half, {kept(half, t[k]), to_next[half], to_last[half]});
    const std::size_t other = 1 - half;
    const std::uint32_t a = to_next[other];
    const std::uint32_t b = kept(other, next);
    const std::uint32_t c = kept(other, last);
    const std::uint32_t d = to_last[other];
    const auto& v = halves_[other].vertices;
    if (squared_distance(v[a].position, v[c].position) <= squared_distance(v[b].position, v[d].position)) {
      emit(other, {a, b, c});
      emit(other, {a, c, d});
    } else {
      emit(other, {a, b, d});
      emit(other, {b, c, d});
    }
  }

  const Mesh& mesh_;
  std::vector<std::int64_t> sides_;
  std::array<std::vector<std::uint32_t>, 2> renumbered_;
  std::unordered_map<std::uint64_t, std::array<std::uint32_t, 2>> cuts_;
  std::array<Mesh, 2> halves_;
};

}  // namespace

std::array<Mesh, 2> split(const Mesh& mesh, const geometry::Plane& plane) {
  return Splitter(mesh, plane).run();
}

}  // namespace colossus::mesh
