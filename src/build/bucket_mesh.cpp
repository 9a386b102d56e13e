#include "build/bucket_mesh.hpp"

#include <algorithm>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "mesh/topology.hpp"

namespace colossus::build {
namespace {

using geometry::Point;
using Wide = __int128;

constexpr std::uint32_t kNone = ~std::uint32_t{0};

struct WideNormal {
  std::array<Wide, 3> sum{};
  template <typename T>
  void add(const std::array<T, 3>& n) {
    for (std::size_t i = 0; i < 3; ++i) sum[i] += n[i];
  }
  bool is_zero() const { return sum[0] == 0 && sum[1] == 0 && sum[2] == 0; }
  mesh::Normal16 normal() const {
    return geometry::to_normal16(static_cast<double>(sum[0]), static_cast<double>(sum[1]),
                                 static_cast<double>(sum[2]));
  }
};

bool is_unknown_normal(const mesh::Normal16& n) { return n[0] == 0 && n[1] == 0 && n[2] == 0; }

// Twice the area long.
std::array<std::int64_t, 3> cross_product(const Point& p, const Point& q, const Point& r) {
  const std::array<std::int64_t, 3> a{std::int64_t{q.x} - p.x, std::int64_t{q.y} - p.y,
                                      std::int64_t{q.z} - p.z};
  const std::array<std::int64_t, 3> b{std::int64_t{r.x} - p.x, std::int64_t{r.y} - p.y,
                                      std::int64_t{r.z} - p.z};
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct ColorSum {
  std::array<std::uint64_t, 4> sum{};
  std::uint64_t count = 0;
  void add(const mesh::Color& color, std::uint64_t times = 1) {
    for (std::size_t k = 0; k < 4; ++k) sum[k] += times * color[k];
    count += times;
  }
  mesh::Color mean() const {
    mesh::Color color;
    for (std::size_t k = 0; k < 4; ++k)
      color[k] = static_cast<std::uint8_t>((2 * sum[k] + count) / (2 * count));
    return color;
  }
};

}  // namespace

BucketMesh::BucketMesh(const Rounding& rounding, const Cube& cube, Piece&& piece)
    : rounding_(rounding), cube_(cube) {
  place(std::move(piece));
  give_attributes();
  if (!rounding_.is_none()) average_rounded();
  round_positions(rounding);
  drop_duplicates();
  count_edges();
}

// One place for all vertices at a position, in order of first use. Only what tells the vertices of a place
// apart is kept of the others.
void BucketMesh::place(Piece&& piece) {
  const std::vector<std::uint32_t> first = mesh::position_remap(piece.vertices);
  std::vector<std::uint32_t> renumbered(piece.vertices.size(), kNone);
  places_.triangles = std::move(piece.triangles);
  for (mesh::Triangle& t : places_.triangles)
    for (auto& v : t) {
      auto& place = renumbered[first[v]];
      if (place == kNone) {
        place = static_cast<std::uint32_t>(places_.vertices.size());
        places_.vertices.push_back(piece.vertices[first[v]]);
      }
      v = place;
    }
  // Groups of triangles bring vertices that they share once each.
  for (std::size_t v = 0; v < first.size(); ++v) {
    if (piece.numbers[v] == piece.numbers[first[v]]) continue;
    const mesh::Vertex& other = piece.vertices[v];
    others_.push_back({renumbered[first[v]], other.normal, other.color, piece.numbers[v]});
  }
  const auto key = [](const Other& other) { return std::tie(other.place, other.number); };
  std::sort(others_.begin(), others_.end(), [&](const Other& a, const Other& b) { return key(a) < key(b); });
  others_.erase(std::unique(others_.begin(), others_.end(),
                            [&](const Other& a, const Other& b) { return key(a) == key(b); }),
                others_.end());
  vertex_counts_.assign(places_.vertices.size(), 1);
  for (const Other& other : others_) ++vertex_counts_[other.place];
}

void BucketMesh::give_attributes() {
  std::vector<bool> is_unknown(places_.vertices.size(), false);
  for (std::uint32_t p = 0; p < is_unknown.size(); ++p)
    is_unknown[p] = is_unknown_normal(places_.vertices[p].normal) && owns_place(p);
  for (std::size_t i = 0; i < others_.size();) {
    const std::uint32_t p = others_[i].place;
    mesh::Vertex& v = places_.vertices[p];
    const bool is_owned = owns_place(p);
    WideNormal read;
    read.add(v.normal);
    ColorSum color;
    color.add(v.color);
    bool differed = false;
    for (; i < others_.size() && others_[i].place == p; ++i) {
      read.add(others_[i].normal);
      color.add(others_[i].color);
      differed |= others_[i].normal != v.normal || others_[i].color != v.color;
    }
    if (!is_owned) continue;
    counts_.merged_vertices += color.count - 1;
    counts_.attribute_seams += differed ? 1 : 0;
    v.color = color.mean();
    is_unknown[p] = read.is_zero();
    if (!is_unknown[p]) v.normal = read.normal();
  }
  others_ = {};
  if (std::find(is_unknown.begin(), is_unknown.end(), true) != is_unknown.end())
    sum_cross_products(is_unknown);
}

void BucketMesh::sum_cross_products(std::vector<bool>& is_unknown) {
  std::vector<WideNormal> sums(places_.vertices.size());
  for (const mesh::Triangle& t : places_.triangles) {
    const auto n = cross_product(places_.vertices[t[0]].position, places_.vertices[t[1]].position,
                                 places_.vertices[t[2]].position);
    for (const auto v : t) sums[v].add(n);
  }
  for (std::size_t p = 0; p < sums.size(); ++p)
    if (is_unknown[p]) places_.vertices[p].normal = sums[p].normal();
}

void BucketMesh::average_rounded() {
  struct Sum {
    WideNormal normal;
    ColorSum color;
  };
  std::vector<mesh::Vertex> rounded = places_.vertices;
  for (mesh::Vertex& v : rounded) v.position = rounding_(v.position);
  const std::vector<std::uint32_t> first = mesh::position_remap(rounded);
  rounded = {};
  std::vector<Sum> sums(places_.vertices.size());
  for (std::size_t p = 0; p < sums.size(); ++p) {
    const mesh::Vertex& v = places_.vertices[p];
    Sum& sum = sums[first[p]];
    sum.color.add(v.color, vertex_counts_[p]);
    for (std::size_t k = 0; k < 3; ++k) sum.normal.sum[k] += Wide{vertex_counts_[p]} * v.normal[k];
  }
  for (std::uint32_t p = 0; p < sums.size(); ++p) {
    const Sum& sum = sums[first[p]];
    if (sum.color.count < 2 || !owns_place(p)) continue;
    places_.vertices[p].normal = sum.normal.normal();
    places_.vertices[p].color = sum.color.mean();
  }
}

void BucketMesh::round_positions(const Rounding& rounding) {
  if (rounding.is_none()) {
    mesh_ = std::move(places_);
    return;
  }
  mesh_ = places_;
  for (mesh::Vertex& v : mesh_.vertices) v.position = rounding(v.position);
  std::vector<std::uint32_t> order;
  mesh::weld(mesh_, &order);
  corners_.reserve(order.size());
  for (const auto i : order) corners_.push_back(places_.triangles[i]);
  places_ = {};
}

// Same positions in the same cyclic order: all but the first go. Each is counted in the one bucket that holds
// its least corner.
void BucketMesh::drop_duplicates() {
  const std::vector<std::uint32_t> first =
      mesh::first_with_same_corners(mesh_.triangles, mesh_.vertices.size());
  const auto was_same = [&](std::uint32_t i, std::uint32_t j) {
    if (corners_.empty()) return true;
    mesh::Triangle a = corners_[i], b = corners_[j];
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
      const auto position = [&](std::uint32_t v) { return mesh_.vertices[v].position; };
      if (cube_.contains(std::min({position(t[0]), position(t[1]), position(t[2])}))) ++counts_.duplicates;
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
  corners_ = {};
}

// An edge is counted in the bucket that holds its lesser end: all triangles at it meet that cube.
void BucketMesh::count_edges() {
  for (const mesh::Edge& edge : mesh::edges(mesh_.triangles)) {
    if (!edge.is_border() && !edge.is_nonmanifold()) continue;
    const bool is_a_lesser = mesh_.vertices[edge.a].position < mesh_.vertices[edge.b].position;
    if (!owns(is_a_lesser ? edge.a : edge.b)) continue;
    ++(edge.is_border() ? counts_.border_edges : counts_.nonmanifold_edges);
  }
}

std::uint64_t bucket_mesh_bytes(std::uint64_t triangles, std::uint64_t vertices_of_pieces) {
  return 150 * triangles + 50 * vertices_of_pieces;
}

}  // namespace colossus::build
