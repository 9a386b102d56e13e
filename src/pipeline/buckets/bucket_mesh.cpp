#include "pipeline/buckets/bucket_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "mesh/topology.hpp"

namespace colossus::pipeline::buckets {
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

// Height of a triangle over its longest edge, squared, up to which the lattice cannot tell its corners from
// three on a line: corners are moved by half the diagonal of a cell.
constexpr double kSquaredFlatness = 3.0 * geometry::kInputSpacing * geometry::kInputSpacing;

bool is_unknown_normal(const mesh::Normal16& n) { return n[0] == 0 && n[1] == 0 && n[2] == 0; }

// Twice the area long.
std::array<std::int64_t, 3> cross_product(const Point& p, const Point& q, const Point& r) {
  const std::array<std::int64_t, 3> a{std::int64_t{q.x} - p.x, std::int64_t{q.y} - p.y,
                                      std::int64_t{q.z} - p.z};
  const std::array<std::int64_t, 3> b{std::int64_t{r.x} - p.x, std::int64_t{r.y} - p.y,
                                      std::int64_t{r.z} - p.z};
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double squared_length(const std::array<std::int64_t, 3>& n) {
  const double x = static_cast<double>(n[0]), y = static_cast<double>(n[1]), z = static_cast<double>(n[2]);
  return x * x + y * y + z * z;
}

// Whether the lattice cannot tell the corners from three on a line.
bool is_flat(const Point& p, const Point& q, const Point& r) {
  const std::int64_t longest =
      std::max({squared_distance(p, q), squared_distance(q, r), squared_distance(r, p)});
  return squared_length(cross_product(p, q, r)) <= kSquaredFlatness * static_cast<double>(longest);
}

mesh::Triangle sorted_corners(mesh::Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
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

BucketMesh::BucketMesh(const Rounding& rounding, const CubeId& cube, const InputBox& box,
                       ingest::Piece&& piece)
    : rounding_(rounding), cube_(cube), box_(box) {
  place(std::move(piece));
  give_attributes();
  if (!rounding_.is_none()) average_rounded();
  drop_copies();
  measure_triangles();
  round_positions();
}

// One place for all vertices at a position, in order of first use. Only what tells the vertices of a place
// apart is kept of the others.
void BucketMesh::place(ingest::Piece&& piece) {
  const std::vector<std::uint32_t> first = mesh::position_remap(piece.vertices);
  std::vector<std::uint32_t> renumbered(piece.vertices.size(), kNone);
  bool is_exact = true;
  for (std::size_t v = 0; v < first.size(); ++v)
    is_exact = is_exact && piece.vertices[v].fingerprint == piece.vertices[first[v]].fingerprint;
  if (!is_exact)
    for (const mesh::Triangle& t : piece.triangles)
      prints_.push_back({piece.vertices[t[0]].fingerprint, piece.vertices[t[1]].fingerprint,
                         piece.vertices[t[2]].fingerprint});
  places_.triangles = std::move(piece.triangles);
  for (mesh::Triangle& t : places_.triangles)
    for (auto& v : t) {
      auto& place = renumbered[first[v]];
      if (place == kNone) {
        place = static_cast<std::uint32_t>(places_.vertices.size());
        places_.vertices.push_back(piece.vertices[first[v]]);
        places_.vertices.back().fingerprint = 0;
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
  std::vector<std::uint64_t> first_vertices(places_.vertices.size());
  for (std::size_t v = 0; v < first.size(); ++v)
    if (renumbered[first[v]] != kNone)
      first_vertices[renumbered[first[v]]] = ingest::vertex_number(piece.numbers[first[v]]);
  mark_corners(first_vertices);
}

// Corners of faces with colours whose vertex is the place's first, or that of an earlier one. Counts the
// vertices.
void BucketMesh::mark_corners(std::span<const std::uint64_t> first_vertices) {
  vertex_counts_.assign(places_.vertices.size(), 1);
  std::vector<std::uint64_t> numbers;  // of the real vertices at a place, which come first
  for (std::size_t begin = 0; begin < others_.size();) {
    const std::uint32_t place = others_[begin].place;
    numbers.clear();
    std::uint64_t last = first_vertices[place];
    std::size_t i = begin;
    for (; i < others_.size() && others_[i].place == place; ++i) {
      Other& other = others_[i];
      const std::uint64_t vertex = ingest::vertex_number(other.number);
      const bool may_be_corner = other.number >= ingest::kFaceCornerNumbers;
      if (!may_be_corner) numbers.push_back(other.number);
      other.is_corner = may_be_corner && (vertex == first_vertices[place] || vertex == last ||
                                          std::binary_search(numbers.begin(), numbers.end(), vertex));
      last = vertex;
      vertex_counts_[place] += other.is_corner ? 0 : 1;
    }
    begin = i;
  }
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
    std::uint64_t merged = 0;
    bool has_other_normal = false;
    bool has_other_color = false;
    for (; i < others_.size() && others_[i].place == p; ++i) {
      color.add(others_[i].color);
      has_other_color |= others_[i].color != v.color;
      if (others_[i].is_corner) continue;
      read.add(others_[i].normal);
      ++merged;
      has_other_normal |= others_[i].normal != v.normal;
    }
    if (!is_owned) continue;
    counts_.merged_vertices += merged;
    counts_.attribute_seams += has_other_normal || has_other_color ? 1 : 0;
    counts_.color_seams += has_other_color ? 1 : 0;
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

// Of triangles over the same points of the input the first stays. What has lost a corner is no triangle any
// more.
void BucketMesh::drop_copies() {
  const std::vector<std::uint32_t> first =
      mesh::first_with_same_corners(places_.triangles, places_.vertices.size());
  std::vector<bool> is_dropped(places_.triangles.size(), false);
  // Of several over the same places, those that stay.
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> groups;
  const auto at = [&](std::uint32_t v) { return places_.vertices[v].position; };
  for (std::uint32_t i = 0; i < places_.triangles.size(); ++i) {
    const mesh::Triangle& t = places_.triangles[i];
    if (mesh::is_degenerate(at(t[0]), at(t[1]), at(t[2]))) {
      is_dropped[i] = true;
      lose({places_.vertices[t[0]], places_.vertices[t[1]], places_.vertices[t[2]]}, 0.0);
      continue;
    }
    if (first[i] == i) continue;
    auto& group = groups.try_emplace(first[i], 1, first[i]).first->second;
    // Two flat ones that look at each other have no area, and close a T-junction from both sides.
    const bool is_level = is_flat(at(t[0]), at(t[1]), at(t[2]));
    const auto copied = std::find_if(group.begin(), group.end(), [&](std::uint32_t j) {
      return are_copies(i, j) && !(is_level && !mesh::has_same_orientation(t, places_.triangles[j]));
    });
    if (copied == group.end()) {
      group.push_back(i);
      continue;
    }
    is_dropped[i] = true;
    if (!owns(t, places_.vertices)) continue;
    ++(mesh::has_same_orientation(t, places_.triangles[*copied]) ? counts_.duplicates : counts_.opposites);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < places_.triangles.size(); ++i)
    if (!is_dropped[i]) places_.triangles[kept++] = places_.triangles[i];
  places_.triangles.resize(kept);
  prints_ = {};
}

// Whether two triangles over the same places have the same points of the input for corners.
bool BucketMesh::are_copies(std::uint32_t i, std::uint32_t j) const {
  if (prints_.empty()) return true;
  const auto corners = [&](std::uint32_t triangle) {
    std::array<std::pair<std::uint32_t, std::uint16_t>, 3> pairs;
    for (std::size_t k = 0; k < 3; ++k) pairs[k] = {places_.triangles[triangle][k], prints_[triangle][k]};
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  };
  return corners(i) == corners(j);
}

// Of the triangles that are left of the input.
void BucketMesh::measure_triangles() {
  for (const mesh::Triangle& t : places_.triangles) {
    if (!owns(t, places_.vertices)) continue;
    const Point &p = places_.vertices[t[0]].position, &q = places_.vertices[t[1]].position,
                &r = places_.vertices[t[2]].position;
    const auto n = cross_product(p, q, r);
    ++counts_.triangles;
    counts_.area += 0.5 * std::sqrt(squared_length(n));
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) ++counts_.collinear;
    for (std::size_t k = 0; k < 4; ++k)
      if (counts_.is_off_diagonal[k] == 0 && !is_on_diagonal(k, {p, q, r})) counts_.is_off_diagonal[k] = 1;
  }
  counts_.input = census_of_edges(places_.triangles, places_.vertices, rounding_, cube_);
}

// Of a line, the input's box has the line for a diagonal: the first axis rises along all four of them, the
// others by the bits of `diagonal`.
bool BucketMesh::is_on_diagonal(std::size_t diagonal, const std::array<Point, 3>& corners) const {
  Point from = box_.low, to = box_.high;
  for (const int axis : {1, 2})
    if ((diagonal >> (axis - 1) & 1) != 0) std::swap(from[axis], to[axis]);
  return std::all_of(corners.begin(), corners.end(), [&](const Point& p) { return is_flat(from, to, p); });
}

void BucketMesh::round_positions() {
  counts_.finest = counts_.input;
  if (rounding_.is_none()) {
    mesh_ = std::move(places_);
    return;
  }
  mesh_ = places_;
  for (mesh::Vertex& v : mesh_.vertices) v.position = rounding_(v.position);
  const std::vector<std::uint32_t> first = mesh::position_remap(mesh_.vertices);
  std::vector<bool> is_shared(first.size(), false);  // whether rounding has brought another place here
  bool is_any_shared = false;
  for (std::size_t p = 0; p < first.size(); ++p)
    if (first[p] != p) is_shared[p] = is_shared[first[p]] = is_any_shared = true;
  if (is_any_shared) settle_rounded(first, is_shared);
  mesh::weld(mesh_);
  places_ = {};
}

// Where places fall together: what collapses is lost, fins go, and edges are others than before. All of that
// has a corner at such a place.
void BucketMesh::settle_rounded(const std::vector<std::uint32_t>& first, const std::vector<bool>& is_shared) {
  std::vector<mesh::Triangle> before, after;
  std::vector<std::uint32_t> touched;
  const auto is_touched = [&](const mesh::Triangle& t) {
    return is_shared[t[0]] || is_shared[t[1]] || is_shared[t[2]];
  };
  for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
    if (is_touched(mesh_.triangles[i])) {
      before.push_back(mesh_.triangles[i]);
      touched.push_back(i);
    }
  const EdgeCensus with = census_of_edges(before, places_.vertices, rounding_, cube_, &is_shared);
  for (mesh::Triangle& t : mesh_.triangles)
    for (auto& v : t) v = first[v];
  const auto vertex = [&](std::uint32_t v) { return mesh_.vertices[v]; };
  std::vector<bool> is_dropped(mesh_.triangles.size(), false);
  for (const auto i : touched) {
    const mesh::Triangle& t = mesh_.triangles[i];
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) continue;
    is_dropped[i] = true;
    lose({vertex(t[0]), vertex(t[1]), vertex(t[2])}, 0.0);
  }
  std::erase_if(touched, [&](std::uint32_t i) { return is_dropped[i]; });
  for (const auto i : touched) after.push_back(mesh_.triangles[i]);
  const EdgeCensus without = census_of_edges(after, mesh_.vertices, {}, cube_, &is_shared);
  counts_.finest = counts_.input - with + without;
  const bool has_fins = drop_fins(touched, is_dropped);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i)
    if (!is_dropped[i]) mesh_.triangles[kept++] = mesh_.triangles[i];
  mesh_.triangles.resize(kept);
  if (has_fins) counts_.finest = census_of_edges(mesh_.triangles, mesh_.vertices, {}, cube_);
}

// Of the touched triangles, pairs of opposite ones go that are no wider than half the diagonal of the grid,
// if their longest edge has other triangles, which are in no pair. On the grid such a pair lies within the
// box of that edge, so every bucket that sees the pair sees these too. Returns whether there were any.
bool BucketMesh::drop_fins(const std::vector<std::uint32_t>& touched, std::vector<bool>& is_dropped) {
  std::map<mesh::Triangle, std::vector<std::uint32_t>> by_corners;
  for (const auto i : touched) by_corners[sorted_corners(mesh_.triangles[i])].push_back(i);
  std::vector<bool> is_in_pair(mesh_.triangles.size(), false);
  std::vector<Fin> fins;
  for (const auto& [corners, together] : by_corners) {
    // What lay at the same places before was laid onto each other by the lattice, if at all: not all buckets
    // see that rounding touches it.
    std::vector<std::uint32_t> group;
    for (const auto i : together)
      if (std::none_of(together.begin(), together.end(), [&](std::uint32_t j) {
            return i != j && sorted_corners(places_.triangles[i]) == sorted_corners(places_.triangles[j]);
          }))
        group.push_back(i);
    std::array<std::vector<std::uint32_t>, 2> sides;
    for (const auto i : group)
      sides[mesh::has_same_orientation(mesh_.triangles[i], mesh_.triangles[group[0]]) ? 0 : 1].push_back(i);
    for (std::size_t k = 0; k < std::min(sides[0].size(), sides[1].size()); ++k) {
      is_in_pair[sides[0][k]] = is_in_pair[sides[1][k]] = true;
      if (const auto fin = fin_of(sides[0][k], sides[1][k])) fins.push_back(*fin);
    }
  }
  if (fins.empty()) return false;
  std::map<std::pair<std::uint32_t, std::uint32_t>, bool> goes_on;  // by longest edge
  for (const Fin& fin : fins) goes_on.try_emplace(fin.longest, false);
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    if (is_in_pair[i] || is_dropped[i]) continue;
    for (std::size_t k = 0; k < 3; ++k)
      if (const auto edge = goes_on.find(std::minmax(mesh_.triangles[i][k], mesh_.triangles[i][(k + 1) % 3]));
          edge != goes_on.end())
        edge->second = true;
  }
  for (const Fin& fin : fins) {
    if (!goes_on[fin.longest]) continue;
    is_dropped[fin.triangles[0]] = is_dropped[fin.triangles[1]] = true;
    const mesh::Triangle& t = mesh_.triangles[fin.triangles[0]];
    lose({mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]}, fin.height);
  }
  return true;
}

// Nothing when it is wider than what rounding may move.
std::optional<BucketMesh::Fin> BucketMesh::fin_of(std::uint32_t one, std::uint32_t other) const {
  const mesh::Triangle& t = mesh_.triangles[one];
  const auto at = [&](std::size_t k) { return mesh_.vertices[t[k % 3]].position; };
  std::size_t longest = 0;
  for (const std::size_t k : {std::size_t{1}, std::size_t{2}})
    if (std::tuple(squared_distance(at(k), at(k + 1)), std::minmax(at(k), at(k + 1))) >
        std::tuple(squared_distance(at(longest), at(longest + 1)), std::minmax(at(longest), at(longest + 1))))
      longest = k;
  const double height = std::sqrt(squared_length(cross_product(at(0), at(1), at(2))) /
                                  static_cast<double>(squared_distance(at(longest), at(longest + 1))));
  if (height > std::sqrt(3.0) / 2.0 * rounding_.spacing) return std::nullopt;
  return Fin{{one, other}, std::minmax(t[longest], t[(longest + 1) % 3]), height};
}

void BucketMesh::lose(const std::array<mesh::Vertex, 3>& corners, double displacement) {
  LostTriangle lost{corners, displacement};
  for (mesh::Vertex& v : lost.corners) v.position = rounding_(v.position);
  lost_.push_back(lost);
}

// Who holds the least corner of a triangle counts it.
bool BucketMesh::owns(const mesh::Triangle& t, const std::vector<mesh::Vertex>& vertices) const {
  const auto at = [&](std::uint32_t v) { return rounding_(vertices[v].position); };
  return cube_.contains(std::min({at(t[0]), at(t[1]), at(t[2])}), geometry::kRootBits);
}

EdgeCensus census_of_edges(std::span<const mesh::Triangle> triangles,
                           const std::vector<mesh::Vertex>& vertices, const Rounding& rounding,
                           const CubeId& cube, const std::vector<bool>* only_at) {
  EdgeCensus census;
  for (const mesh::Edge& edge : mesh::edges(triangles)) {
    const bool is_inconsistent = edge.count() == 2 && edge.forward != edge.backward;
    if (edge.count() == 2 && !is_inconsistent) continue;
    if (only_at != nullptr && !(*only_at)[edge.a] && !(*only_at)[edge.b]) continue;
    if (!cube.contains(std::min(rounding(vertices[edge.a].position), rounding(vertices[edge.b].position)),
                       geometry::kRootBits))
      continue;
    census.border += edge.is_border() ? 1 : 0;
    census.nonmanifold += edge.is_nonmanifold() ? 1 : 0;
    census.inconsistent += is_inconsistent ? 1 : 0;
  }
  return census;
}

std::uint64_t bucket_mesh_bytes(std::uint64_t triangles, std::uint64_t vertices_of_pieces) {
  return 150 * triangles + 50 * vertices_of_pieces;
}

}  // namespace colossus::pipeline::buckets
