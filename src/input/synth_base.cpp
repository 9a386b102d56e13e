// A mesh of the user's as the base shape of synth, each triangle subdivided into k x k.
//
// The surface is that of point-normal triangles (Vlachos, Peters, Boyd, Mitchell: Curved PN Triangles, 2001):
// a cubic patch per triangle, whose border curves depend on the two ends and their normals alone. We depart
// from it at border and non-manifold edges: their vertices have no normal, which makes these edges straight
// and keeps the relief away.
//
// Vertices are numbered: those of the base, then k - 1 on each edge from its lower end, then those inside
// each triangle.
#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.hpp"
#include "input/synth_surface.hpp"

namespace colossus::input {
namespace {

using Point = std::array<double, 3>;
using Triangle = std::array<std::uint32_t, 3>;

Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point operator*(const Point& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
double dot(const Point& a, const Point& b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

void check_base(const BaseMesh& base) {
  using core::Status;
  if (base.triangles.empty()) core::fail(Status::kBadData, "{}: no triangles to subdivide", base.name);
  if (base.positions.size() >= kMaxSynthVertices || base.triangles.size() >= kMaxSynthVertices)
    core::fail(Status::kBadData,
               "{}: {} vertices and {} triangles; a base mesh may have less than 2^31 of each", base.name,
               base.positions.size(), base.triangles.size());
  if (!base.colors.empty() && base.colors.size() != base.positions.size())
    core::fail(Status::kBadData, "{}: {} colors for {} vertices", base.name, base.colors.size(),
               base.positions.size());
  for (std::size_t i = 0; i < base.positions.size(); ++i)
    for (const double c : base.positions[i])
      if (!std::isfinite(c))
        core::fail(Status::kBadData, "{}: vertex {}: a coordinate is {}", base.name, i, c);
  for (std::size_t i = 0; i < base.triangles.size(); ++i)
    for (const std::uint32_t v : base.triangles[i])
      if (v >= base.positions.size())
        core::fail(Status::kBadData, "{}: face {}: vertex index {}, but there are {} vertices", base.name, i,
                   v, base.positions.size());
}

// The base mesh with vertices at equal positions made one, numbered by first use in a triangle; its edges
// numbered by first use; normals (zero on border and non-manifold edges).
struct WeldedBase {
  std::vector<Point> positions, normals;
  std::vector<std::array<std::uint8_t, 3>> colors;
  std::vector<Triangle> triangles;
  std::vector<std::array<std::uint32_t, 2>> edges;  // lower end first
  std::vector<Triangle> triangle_edges;             // edge i joins corners i and i + 1
};

// For each vertex, the first one at the same position; -0 and 0 are the same.
std::vector<std::uint32_t> first_at_position(const std::vector<Point>& positions) {
  std::vector<std::uint32_t> order(positions.size()), first(positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return positions[a] != positions[b] ? positions[a] < positions[b] : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && positions[order[i]] == positions[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

void weld(const BaseMesh& base, WeldedBase& mesh) {
  constexpr std::uint32_t kUnused = 0xffffffffU;
  const std::vector<std::uint32_t> first = first_at_position(base.positions);
  std::vector<std::uint32_t> number(base.positions.size(), kUnused);
  for (const Triangle& corners : base.triangles) {
    Triangle triangle = {first[corners[0]], first[corners[1]], first[corners[2]]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    for (std::uint32_t& v : triangle) {
      if (number[v] == kUnused) {
        number[v] = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(base.positions[v]);
        if (!base.colors.empty()) mesh.colors.push_back(base.colors[v]);
      }
      v = number[v];
    }
    mesh.triangles.push_back(triangle);
  }
  if (mesh.triangles.empty())
    core::fail(core::Status::kBadData, "{}: all triangles are degenerate", base.name);
}

// Numbers the edges. Returns for each whether it has other than two triangles of opposite directions.
std::vector<bool> number_edges(WeldedBase& mesh) {
  struct Side {
    std::uint32_t low, high;
    std::uint64_t corner;  // 3 * triangle + i
    bool reversed;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), 3 * t + i, a > b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.corner < b.corner;
  });
  // The first side of an edge stands for it until the edges are numbered in the order of these.
  std::vector<std::uint64_t> leader(sides.size());
  std::vector<bool> special_side(sides.size());
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    std::size_t reversed = 0;
    for (; end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high;
         ++end) {
      leader[sides[end].corner] = sides[begin].corner;
      reversed += sides[end].reversed;
    }
    special_side[sides[begin].corner] = end - begin != 2 || reversed != 1;
  }
  std::vector<bool> special;
  mesh.triangle_edges.resize(mesh.triangles.size());
  for (std::size_t corner = 0; corner < leader.size(); ++corner) {
    const std::size_t t = corner / 3, i = corner % 3;
    if (leader[corner] != corner) {
      mesh.triangle_edges[t][i] = mesh.triangle_edges[leader[corner] / 3][leader[corner] % 3];
      continue;
    }
    const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
    mesh.triangle_edges[t][i] = static_cast<std::uint32_t>(mesh.edges.size());
    mesh.edges.push_back({std::min(a, b), std::max(a, b)});
    special.push_back(special_side[corner]);
  }
  return special;
}

// Area-weighted unit normals; zero at the ends of special edges and where triangles cancel out.
void compute_normals(WeldedBase& mesh, const std::vector<bool>& special) {
  mesh.normals.assign(mesh.positions.size(), Point{});
  for (const Triangle& t : mesh.triangles) {
    const Point& a = mesh.positions[t[0]];
    const Point area = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
    for (const std::uint32_t v : t) mesh.normals[v] = mesh.normals[v] + area;
  }
  for (Point& normal : mesh.normals) {
    const double length = std::sqrt(dot(normal, normal));
    normal = length > 0 && std::isfinite(length) ? normal * (1 / length) : Point{};
  }
  for (std::size_t e = 0; e < mesh.edges.size(); ++e)
    if (special[e])
      for (const std::uint32_t v : mesh.edges[e]) mesh.normals[v] = Point{};
}

// The control point next to `a` of the cubic border curve from `a` to `b`.
Point curve_control(const WeldedBase& mesh, std::uint32_t a, std::uint32_t b) {
  const Point& pa = mesh.positions[a];
  const Point along = mesh.positions[b] - pa;
  const Point& normal = mesh.normals[a];
  return (pa * 3 + (along - normal * dot(along, normal))) * (1.0 / 3);
}

class SubdividedSurface final : public SynthSurface {
 public:
  SubdividedSurface(const BaseMesh& base, std::uint64_t triangles);

  std::uint64_t vertex_count() const override {
    return first_inner_ + mesh_.triangles.size() * inner_per_triangle_;
  }
  std::uint64_t triangle_count() const override { return mesh_.triangles.size() * k_ * k_; }
  bool has_colors() const override { return !mesh_.colors.empty(); }
  double extent() const override { return extent_; }
  double relief_wavelength() const override { return 2 * base_edge_; }
  double mean_edge() const override { return base_edge_ / static_cast<double>(k_); }
  double largest_coordinate() const override { return largest_coordinate_; }
  void evaluate(std::span<const std::uint32_t> vertices, SurfaceBatch& batch) const override;
  void add_carving(const PointBatch&, std::size_t, Lane&) const override {}
  void triangles(std::uint64_t first, std::span<std::array<std::uint32_t, 3>> corners) const override;

 private:
  // The control points of a triangle's patch: corners are in the mesh; two per edge, from corner i to i + 1;
  // middle.
  struct Patch {
    std::uint64_t triangle = ~std::uint64_t{0};
    std::array<std::array<Point, 2>, 3> border{};
    Point middle{};
  };
  // What a vertex is made of: up to three base vertices with weights that sum to 1.
  struct Blend {
    Triangle corners;
    std::array<double, 3> weights;
    Point position;
  };
  Patch make_patch(std::uint64_t triangle) const;
  Blend blend_on_edge(std::uint64_t index) const;
  Blend blend_inside(std::uint64_t index, Patch& patch) const;
  std::uint32_t vertex_at(std::uint64_t triangle, std::uint64_t row, std::uint64_t column) const;
  void measure();

  WeldedBase mesh_;
  std::uint64_t k_ = 1;
  std::uint64_t first_inner_ = 0, inner_per_triangle_ = 0;
  Point origin_{};
  double extent_ = 1, base_edge_ = 1, largest_coordinate_ = 1;
};

SubdividedSurface::SubdividedSurface(const BaseMesh& base, std::uint64_t triangles) {
  check_base(base);
  weld(base, mesh_);
  compute_normals(mesh_, number_edges(mesh_));
  measure();
  const auto faces = static_cast<double>(mesh_.triangles.size()), wanted = static_cast<double>(triangles);
  // Between k and k + 1 the nearer count; 2^31 vertices are exceeded long before k is.
  const double k = std::min(std::max(1.0, std::floor(std::sqrt(wanted / faces))), 65536.0);
  const bool one_more = std::abs((k + 1) * (k + 1) * faces - wanted) < std::abs(k * k * faces - wanted);
  k_ = static_cast<std::uint64_t>(k) + (one_more ? 1 : 0);
  inner_per_triangle_ = (k_ - 1) * (k_ > 1 ? k_ - 2 : 0) / 2;
  first_inner_ = mesh_.positions.size() + mesh_.edges.size() * (k_ - 1);
  if (vertex_count() > kMaxSynthVertices)
    core::fail(core::Status::kUsage, "synth: {} triangles on {} need {} vertices; at most {} are supported",
               triangles, base.name, vertex_count(), kMaxSynthVertices);
}

void SubdividedSurface::measure() {
  Point low = mesh_.positions.front(), high = low;
  for (const Point& p : mesh_.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  largest_coordinate_ = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    origin_[i] = low[i] + (high[i] - low[i]) / 2;
    largest_coordinate_ = std::max({largest_coordinate_, std::abs(low[i]), std::abs(high[i])});
  }
  const Point size = high - low;
  extent_ = std::max({size[0], size[1], size[2]});
  double length = 0;
  for (const auto& [a, b] : mesh_.edges) {
    const Point along = mesh_.positions[b] - mesh_.positions[a];
    length += std::sqrt(dot(along, along));
  }
  base_edge_ = length / static_cast<double>(mesh_.edges.size());
}

SubdividedSurface::Patch SubdividedSurface::make_patch(std::uint64_t triangle) const {
  const Triangle& corners = mesh_.triangles[triangle];
  Patch patch;
  patch.triangle = triangle;
  Point sum{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
    patch.border[i] = {curve_control(mesh_, a, b), curve_control(mesh_, b, a)};
    sum = sum + patch.border[i][0] + patch.border[i][1];
  }
  const Point flat = mesh_.positions[corners[0]] + mesh_.positions[corners[1]] + mesh_.positions[corners[2]];
  patch.middle = sum * (1.0 / 4) - flat * (1.0 / 6);
  return patch;
}

SubdividedSurface::Blend SubdividedSurface::blend_on_edge(std::uint64_t index) const {
  const auto [a, b] = mesh_.edges[index / (k_ - 1)];
  const double t = static_cast<double>(index % (k_ - 1) + 1) / static_cast<double>(k_), s = 1 - t;
  const Point position = (mesh_.positions[a] * (s * s * s) + curve_control(mesh_, a, b) * (3 * s * s * t)) +
                         (curve_control(mesh_, b, a) * (3 * s * t * t) + mesh_.positions[b] * (t * t * t));
  return {{a, b, b}, {s, t, 0}, position};
}

SubdividedSurface::Blend SubdividedSurface::blend_inside(std::uint64_t index, Patch& patch) const {
  const std::uint64_t triangle = index / inner_per_triangle_, inner = index % inner_per_triangle_;
  if (patch.triangle != triangle) patch = make_patch(triangle);
  // Row r of the inner vertices begins at number r * (r + 1) / 2.
  auto row = static_cast<std::uint64_t>((std::sqrt(8 * static_cast<double>(inner) + 1) - 1) / 2);
  while (row * (row + 1) / 2 > inner) --row;
  while ((row + 1) * (row + 2) / 2 <= inner) ++row;
  const auto columns = static_cast<double>(inner - row * (row + 1) / 2 + 1),
             rows = static_cast<double>(row + 2);
  const auto k = static_cast<double>(k_);
  const double u = (k - rows) / k, v = (rows - columns) / k, w = columns / k;
  const Triangle& corners = mesh_.triangles[triangle];
  const auto& [ab, bc, ca] = patch.border;
  const Point ends = mesh_.positions[corners[0]] * (u * u * u) + mesh_.positions[corners[1]] * (v * v * v) +
                     mesh_.positions[corners[2]] * (w * w * w);
  const Point borders = ab[0] * (3 * u * u * v) + ab[1] * (3 * u * v * v) + bc[0] * (3 * v * v * w) +
                        bc[1] * (3 * v * w * w) + ca[0] * (3 * w * w * u) + ca[1] * (3 * w * u * u);
  return {corners, {u, v, w}, ends + borders + patch.middle * (6 * u * v * w)};
}

void SubdividedSurface::evaluate(std::span<const std::uint32_t> vertices, SurfaceBatch& batch) const {
  Patch patch;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::uint64_t vertex = vertices[i], corners = mesh_.positions.size();
    const Blend blend =
        vertex < corners ? Blend{{vertices[i], vertices[i], vertices[i]}, {1, 0, 0}, mesh_.positions[vertex]}
        : vertex < first_inner_ ? blend_on_edge(vertex - corners)
                                : blend_inside(vertex - first_inner_, patch);
    const auto& [u, v, w] = blend.weights;
    const auto& [a, b, c] = blend.corners;
    const Point normal = mesh_.normals[a] * u + mesh_.normals[b] * v + mesh_.normals[c] * w;
    const Point local = blend.position - origin_;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      batch.position[axis][i] = blend.position[axis];
      (axis == 0   ? batch.local.x
       : axis == 1 ? batch.local.y
                   : batch.local.z)[i] = static_cast<float>(local[axis]);
      (axis == 0   ? batch.normal.x
       : axis == 1 ? batch.normal.y
                   : batch.normal.z)[i] = static_cast<float>(normal[axis]);
      if (mesh_.colors.empty()) continue;
      const double color = mesh_.colors[a][axis] * u + mesh_.colors[b][axis] * v + mesh_.colors[c][axis] * w;
      (axis == 0 ? batch.color.x : axis == 1 ? batch.color.y : batch.color.z)[i] = static_cast<float>(color);
    }
  }
}

// The vertex in row 0..k from the first corner, column 0..row from the side of the second.
std::uint32_t SubdividedSurface::vertex_at(std::uint64_t triangle, std::uint64_t row,
                                           std::uint64_t column) const {
  const Triangle& corners = mesh_.triangles[triangle];
  const std::uint64_t a = k_ - row, b = row - column, c = column;
  if (a == k_) return corners[0];
  if (b == k_) return corners[1];
  if (c == k_) return corners[2];
  if (a > 0 && b > 0 && c > 0)
    return static_cast<std::uint32_t>(first_inner_ + triangle * inner_per_triangle_ +
                                      (row - 2) * (row - 1) / 2 + column - 1);
  // On the edge from `side` to the next corner, `steps` from its beginning.
  const std::size_t side = c == 0 ? 0 : a == 0 ? 1 : 2;
  const std::uint64_t steps = side == 0 ? b : side == 1 ? c : a;
  const std::uint32_t edge = mesh_.triangle_edges[triangle][side];
  const std::uint64_t from_low = mesh_.edges[edge][0] == corners[side] ? steps : k_ - steps;
  return static_cast<std::uint32_t>(mesh_.positions.size() + edge * (k_ - 1) + from_low - 1);
}

void SubdividedSurface::triangles(std::uint64_t first,
                                  std::span<std::array<std::uint32_t, 3>> corners) const {
  const std::uint64_t per_triangle = k_ * k_;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint64_t triangle = (first + i) / per_triangle, part = (first + i) % per_triangle;
    // Row r has 2 r + 1 parts and begins at part r * r.
    auto row = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(part)));
    while (row * row > part) --row;
    while ((row + 1) * (row + 1) <= part) ++row;
    const std::uint64_t across = part - row * row, column = across / 2;
    if (across % 2 == 0)
      corners[i] = {vertex_at(triangle, row, column), vertex_at(triangle, row + 1, column),
                    vertex_at(triangle, row + 1, column + 1)};
    else
      corners[i] = {vertex_at(triangle, row, column), vertex_at(triangle, row + 1, column + 1),
                    vertex_at(triangle, row, column + 1)};
  }
}

}  // namespace

std::unique_ptr<SynthSurface> make_subdivided_surface(const BaseMesh& base, std::uint64_t triangles) {
  return std::make_unique<SubdividedSurface>(base, triangles);
}

}  // namespace colossus::input
