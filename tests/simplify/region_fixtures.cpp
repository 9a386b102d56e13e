#include "simplify/region_fixtures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "mesh/clip.hpp"

namespace colossus::simplify {
namespace {

Plane opposite(Plane plane) {
  for (auto& component : plane.normal) component = static_cast<std::int8_t>(-component);
  plane.offset = -plane.offset;
  return plane;
}

// Every vertex and the middle of every triangle of the region, anchored there.
std::vector<SurfaceSample> samples_of(const Region& region) {
  std::vector<SurfaceSample> samples;
  for (std::size_t i = 0; i < region.mesh.triangles.size(); ++i) {
    const Triangle& t = region.mesh.triangles[i];
    const Vec3 middle = (1.0 / 3.0) * (at(region.mesh, t[0]) + at(region.mesh, t[1]) + at(region.mesh, t[2]));
    const Point rounded{static_cast<std::int32_t>(middle.x), static_cast<std::int32_t>(middle.y),
                        static_cast<std::int32_t>(middle.z)};
    for (const Point& p : {rounded, region.mesh.vertices[t[0]].position})
      samples.push_back({p, t[0], 0.0F, region.cells[i]});
  }
  return samples;
}

}  // namespace

Point input_point(const Vec3& p) {
  const auto put = [](double value, int residue) {
    return (static_cast<std::int32_t>(value) & ~7) | residue;
  };
  return {put(p.x, 1), put(p.y, 2), put(p.z, 4)};
}

mesh::Vertex vertex_at(const Point& position) {
  mesh::Vertex vertex;
  vertex.position = position;
  return vertex;
}

Mesh sphere(int depth, double noise, std::uint64_t seed) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<Vec3> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                           {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Triangle> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                  {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                  {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                  {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (Vec3& p : points) p = (1.0 / geometry::length(p)) * p;
  for (int level = 0; level < depth; ++level) {
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, is_new] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(points.size()));
      const Vec3 sum = points[a] + points[b];
      if (is_new) points.push_back((1.0 / geometry::length(sum)) * sum);
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (const Triangle& t : triangles) {
      const Triangle m{middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
      finer.insert(finer.end(), {{t[0], m[0], m[2]}, {t[1], m[1], m[0]}, {t[2], m[2], m[1]}, m});
    }
    triangles = std::move(finer);
  }
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> radial(1.0 - noise, 1.0 + noise);
  Mesh mesh;
  for (const Vec3& p : points)
    mesh.vertices.push_back(vertex_at(input_point(kCenter + kRadius * radial(random) * p)));
  mesh.triangles = std::move(triangles);
  return mesh;
}

Mesh wavy_grid(std::uint32_t n) {
  Mesh mesh;
  const double low = 0.1 * geometry::kRootSide;
  const double step = 0.8 * geometry::kRootSide / n;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t k = 0; k <= n; ++k) {
      const double wave = std::sin(0.3 * i) * std::cos(0.23 * k);
      mesh.vertices.push_back(vertex_at(
          input_point({low + step * i, low + step * k, kMiddle + 0.02 * geometry::kRootSide * wave})));
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t v = i * (n + 1) + k;
      mesh.triangles.push_back({v, v + n + 1, v + n + 2});
      mesh.triangles.push_back({v, v + n + 2, v + 1});
    }
  return mesh;
}

Mesh rough_sheet(std::uint32_t columns, std::uint32_t rows, double height, std::uint64_t seed) {
  Mesh mesh;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> shift(-1.0, 1.0);
  const double side = 0.8 * geometry::kRootSide / std::max(columns, rows);
  for (std::uint32_t i = 0; i <= columns; ++i)
    for (std::uint32_t k = 0; k <= rows; ++k) {
      const double x = (i - 0.5 * columns + 0.2 * shift(random)) * side;
      const double y = (k - 0.5 * rows + 0.2 * shift(random)) * side;
      mesh.vertices.push_back(vertex_at(input_point(kCenter + Vec3{x, y, height * shift(random) * side})));
    }
  for (std::uint32_t i = 0; i < columns; ++i)
    for (std::uint32_t k = 0; k < rows; ++k) {
      const std::uint32_t v = i * (rows + 1) + k;
      const std::uint32_t w = v + rows + 1;
      if (random() % 2 == 0)
        mesh.triangles.insert(mesh.triangles.end(), {{v, w, w + 1}, {v, w + 1, v + 1}});
      else
        mesh.triangles.insert(mesh.triangles.end(), {{v, w, v + 1}, {w, w + 1, v + 1}});
    }
  return mesh;
}

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

Region make_region(const Mesh& mesh, const std::vector<Plane>& inner, const std::vector<Plane>& outer) {
  Mesh clipped = mesh;
  for (const Plane& plane : outer) clipped = mesh::split(clipped, plane)[0];
  std::vector<Mesh> parts{clipped};
  for (const Plane& plane : inner) {
    std::vector<Mesh> halves;
    for (const Mesh& part : parts)
      for (const Mesh& half : mesh::split(part, plane)) halves.push_back(half);
    parts = std::move(halves);
  }
  Region region;
  std::vector<std::uint16_t> cells;
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    append(region.mesh, parts[cell]);
    cells.resize(region.mesh.triangles.size(), static_cast<std::uint16_t>(cell));
    std::array<Plane, 4> planes{};
    planes.fill({{1, 0, 0}, 0});
    for (std::size_t i = 0; i < inner.size(); ++i)
      planes[i] = (cell >> (inner.size() - 1 - i) & 1) != 0 ? opposite(inner[i]) : inner[i];
    std::copy(outer.begin(), outer.end(), planes.begin() + static_cast<std::ptrdiff_t>(inner.size()));
    region.cell_planes.push_back(planes);
  }
  std::vector<std::uint32_t> order;
  mesh::weld(region.mesh, &order);
  for (const std::uint32_t former : order) region.cells.push_back(cells[former]);
  std::vector<Plane> all = inner;
  all.insert(all.end(), outer.begin(), outer.end());
  for (const mesh::Vertex& vertex : region.mesh.vertices) {
    FaceMask mask = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].side(vertex.position) == 0) mask |= FaceMask{1} << i;
    region.faces.push_back(mask);
  }
  for (std::size_t i = inner.size(); i < all.size(); ++i) region.outer_faces |= FaceMask{1} << i;
  region.samples = samples_of(region);
  return region;
}

void expect_in_cells(const Region& region) {
  ASSERT_EQ(region.cells.size(), region.mesh.triangles.size());
  for (std::size_t i = 0; i < region.cells.size(); ++i)
    for (const Plane& plane : region.cell_planes[region.cells[i]])
      for (const auto v : region.mesh.triangles[i])
        ASSERT_GE(plane.side(region.mesh.vertices[v].position), 0);
}

}  // namespace colossus::simplify
