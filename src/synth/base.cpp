// A mesh of the user's as the base shape of synth, subdivided.
//
// The surface is that of point-normal triangles (Vlachos, Peters, Boyd, Mitchell: Curved PN Triangles, 2001):
// a cubic patch per triangle, whose border curves depend on the two ends and their normals alone. We depart
// from it at border and non-manifold edges: their vertices have no normal, which makes these edges straight
// and keeps the relief away.
#include <algorithm>
#include <cmath>

#include "synth/subdivision.hpp"
#include "synth/surface.hpp"
#include "synth/welded_base.hpp"

namespace colossus::synth {
namespace {

using namespace synth_points;
using Triangle = std::array<std::uint32_t, 3>;

// The control point next to `a` of the cubic border curve from `a` to `b`.
Point curve_control(const WeldedBase& mesh, std::uint32_t a, std::uint32_t b) {
  const Point& pa = mesh.positions[a];
  const Point along = mesh.positions[b] - pa;
  const Point& normal = mesh.normals[a];
  return (pa * 3 + (along - normal * dot(along, normal))) * (1.0 / 3);
}

class SubdividedSurface final : public SynthSurface {
 public:
  SubdividedSurface(const BaseMesh& base, std::uint64_t triangles)
      : mesh_(weld_base(base)), subdivision_(mesh_, triangles, base.name) {
    measure();
  }

  std::uint64_t vertex_count() const override { return subdivision_.vertex_count(); }
  std::uint64_t triangle_count() const override { return subdivision_.triangle_count(); }
  bool has_colors() const override { return !mesh_.colors.empty(); }
  double extent() const override { return extent_; }
  double relief_wavelength() const override { return 2 * base_edge_; }
  double mean_edge() const override { return mean_edge_; }
  double largest_coordinate() const override { return largest_coordinate_; }
  void evaluate(std::span<const std::uint32_t> vertices, SurfaceBatch& batch) const override;
  void add_carving(const PointBatch&, std::size_t, Lane&) const override {}
  void triangles(std::uint64_t first, std::span<std::array<std::uint32_t, 3>> corners) const override {
    subdivision_.triangles(first, corners);
  }
  void triangles_at(std::span<const std::uint64_t> numbers,
                    std::span<std::array<std::uint32_t, 3>> corners) const override {
    subdivision_.triangles_at(numbers, corners);
  }

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
  Blend blend_on_edge(const SynthSubdivision::OnEdge& place) const;
  Blend blend_inside(const SynthSubdivision::Inside& place, Patch& patch) const;
  void measure();

  WeldedBase mesh_;
  SynthSubdivision subdivision_;
  Point origin_{};
  double extent_ = 1, base_edge_ = 1, mean_edge_ = 1, largest_coordinate_ = 1;
};

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
  mean_edge_ = base_edge_ / std::sqrt(static_cast<double>(subdivision_.triangle_count()) /
                                      static_cast<double>(mesh_.triangles.size()));
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

SubdividedSurface::Blend SubdividedSurface::blend_on_edge(const SynthSubdivision::OnEdge& place) const {
  const auto [a, b] = mesh_.edges[place.edge];
  const double t = static_cast<double>(place.step) / static_cast<double>(place.segments), s = 1 - t;
  const Point position = (mesh_.positions[a] * (s * s * s) + curve_control(mesh_, a, b) * (3 * s * s * t)) +
                         (curve_control(mesh_, b, a) * (3 * s * t * t) + mesh_.positions[b] * (t * t * t));
  return {{a, b, b}, {s, t, 0}, position};
}

SubdividedSurface::Blend SubdividedSurface::blend_inside(const SynthSubdivision::Inside& place,
                                                         Patch& patch) const {
  if (patch.triangle != place.triangle) patch = make_patch(place.triangle);
  const auto segments = static_cast<double>(place.segments), row = static_cast<double>(place.row),
             column = static_cast<double>(place.column);
  const double u = (segments - row) / segments, v = (row - column) / segments, w = column / segments;
  const Triangle& corners = mesh_.triangles[place.triangle];
  const auto& [ab, bc, ca] = patch.border;
  const Point ends = mesh_.positions[corners[0]] * (u * u * u) + mesh_.positions[corners[1]] * (v * v * v) +
                     mesh_.positions[corners[2]] * (w * w * w);
  const Point borders = ab[0] * (3 * u * u * v) + ab[1] * (3 * u * v * v) + bc[0] * (3 * v * v * w) +
                        bc[1] * (3 * v * w * w) + ca[0] * (3 * w * w * u) + ca[1] * (3 * w * u * u);
  return {corners, {u, v, w}, ends + borders + patch.middle * (6 * u * v * w)};
}

void SubdividedSurface::evaluate(std::span<const std::uint32_t> vertices, SurfaceBatch& batch) const {
  Patch patch;
  std::uint32_t near_edge = 0, near_triangle = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::uint32_t vertex = vertices[i];
    const Blend blend = vertex < subdivision_.first_on_edges()
                            ? Blend{{vertex, vertex, vertex}, {1, 0, 0}, mesh_.positions[vertex]}
                        : vertex < subdivision_.first_inside()
                            ? blend_on_edge(subdivision_.on_edge(vertex, near_edge))
                            : blend_inside(subdivision_.inside(vertex, near_triangle), patch);
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

}  // namespace

std::unique_ptr<SynthSurface> make_subdivided_surface(const BaseMesh& base, std::uint64_t triangles) {
  return std::make_unique<SubdividedSurface>(base, triangles);
}

}  // namespace colossus::synth
