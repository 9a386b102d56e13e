#include <gtest/gtest.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "geometry/vector.hpp"
#include "mesh/clip.hpp"
#include "mesh/topology.hpp"
#include "simplify/collapse.hpp"
#include "simplify/deviation.hpp"
#include "simplify/vertex_class.hpp"

namespace colossus::simplify {
namespace {

using geometry::Plane;
using geometry::Point;
using geometry::Vec3;
using mesh::Mesh;
using mesh::Triangle;

constexpr std::int32_t kMiddle = geometry::kRootSide / 2;
constexpr double kRadius = 0.25 * geometry::kRootSide;
const Vec3 kCenter{kMiddle, kMiddle, kMiddle};

Vec3 at(const Mesh& mesh, std::uint32_t v) { return geometry::to_vec3(mesh.vertices[v].position); }

// At the residues of input vertices, so on no plane of the cells below.
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

// A geodesic sphere of 20 * 4^depth triangles facing outward, its vertices moved along the radius by up to
// `noise` of it.
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

// A square of n * n squares over [low, high] in x and y, wavy in z everywhere, its border too.
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

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

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

// A task's region: what lies on the positive side of the outer planes, cut by the inner planes into a cell
// per combination of sides. Bit i of the masks is inner plane i, the outer ones follow. At most three planes
// in all.
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
  std::vector<std::uint8_t> cells;
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    append(region.mesh, parts[cell]);
    cells.resize(region.mesh.triangles.size(), static_cast<std::uint8_t>(cell));
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

const std::vector<Plane> kInnerPlanes{{{1, 0, 0}, kMiddle}, {{0, 1, -1}, 0}};
const std::vector<Plane> kOuterPlanes{{{0, 0, 1}, kMiddle - kMiddle / 8}};
constexpr FaceMask kOuterFace = 4;

using PointEdge = std::array<Point, 2>;
PointEdge point_edge(const Mesh& mesh, const mesh::Edge& edge) {
  const Point a = mesh.vertices[edge.a].position;
  const Point b = mesh.vertices[edge.b].position;
  return {std::min(a, b), std::max(a, b)};
}

template <typename Predicate>
std::multiset<PointEdge> edges_where(const Mesh& mesh, const Predicate& predicate) {
  std::multiset<PointEdge> found;
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles))
    if (predicate(edge)) found.insert(point_edge(mesh, edge));
  return found;
}

void expect_closed(const Mesh& mesh) {
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles)) {
    ASSERT_EQ(edge.forward, 1U);
    ASSERT_EQ(edge.backward, 1U);
  }
}

void expect_in_cells(const Region& region) {
  ASSERT_EQ(region.cells.size(), region.mesh.triangles.size());
  for (std::size_t i = 0; i < region.cells.size(); ++i)
    for (const Plane& plane : region.cell_planes[region.cells[i]])
      for (const auto v : region.mesh.triangles[i])
        ASSERT_GE(plane.side(region.mesh.vertices[v].position), 0);
}

// --- distances by brute force, independent of geometry/vector.hpp's ---

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double squared = geometry::squared_length(along);
  const double t = squared > 0.0 ? std::clamp(geometry::dot(p - a, along) / squared, 0.0, 1.0) : 0.0;
  return geometry::length(a + t * along - p);
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double rim =
      std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
  const Vec3 normal = geometry::cross(b - a, c - a);
  const double area = geometry::length(normal);
  if (!(area > 0.0)) return rim;
  const auto is_left = [&](const Vec3& from, const Vec3& to) {
    return geometry::dot(geometry::cross(to - from, p - from), normal) >= 0.0;
  };
  if (!is_left(a, b) || !is_left(b, c) || !is_left(c, a)) return rim;
  return std::min(rim, std::abs(geometry::dot(p - a, normal)) / area);
}

// All triangles of a mesh, each in a ball so that most need no closer look.
class BruteForce {
 public:
  explicit BruteForce(const Mesh& mesh) {
    for (const Triangle& t : mesh.triangles) {
      const std::array<Vec3, 3> corners{at(mesh, t[0]), at(mesh, t[1]), at(mesh, t[2])};
      const Vec3 middle = (1.0 / 3.0) * (corners[0] + corners[1] + corners[2]);
      double radius = 0.0;
      for (const Vec3& corner : corners) radius = std::max(radius, geometry::length(corner - middle));
      balls_.push_back({corners, middle, radius});
    }
  }
  double distance(const Vec3& p) const {
    double best = std::numeric_limits<double>::infinity();
    for (const Ball& ball : balls_) {
      const double reach = best + ball.radius;
      if (geometry::squared_length(p - ball.middle) > reach * reach) continue;
      best = std::min(best, distance_to_triangle(p, ball.corners[0], ball.corners[1], ball.corners[2]));
    }
    return best;
  }

 private:
  struct Ball {
    std::array<Vec3, 3> corners;
    Vec3 middle;
    double radius;
  };
  std::vector<Ball> balls_;
};

// Points spread evenly over a surface.
std::vector<Vec3> spread_points(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  std::vector<double> areas;
  for (const Triangle& t : mesh.triangles)
    areas.push_back(
        geometry::length(geometry::cross(at(mesh, t[1]) - at(mesh, t[0]), at(mesh, t[2]) - at(mesh, t[0]))));
  std::mt19937_64 random(seed);
  std::discrete_distribution<std::size_t> triangle(areas.begin(), areas.end());
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Triangle& t = mesh.triangles[triangle(random)];
    double u = share(random);
    double v = share(random);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    points.push_back(at(mesh, t[0]) + u * (at(mesh, t[1]) - at(mesh, t[0])) +
                     v * (at(mesh, t[2]) - at(mesh, t[0])));
  }
  return points;
}

double rms_distance(const Mesh& from, const Mesh& to) {
  const BruteForce surface(to);
  double sum = 0.0;
  const auto points = spread_points(from, 4000, 1);
  for (const Vec3& p : points) {
    const double d = surface.distance(p);
    sum += d * d;
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

// --- the outcome ---

TEST(Simplify, ReachesItsTargetOnANoisySphere) {
  const Mesh original = sphere(4, 0.005, 1);
  for (const std::size_t divisor : {1U, 2U, 4U, 16U, 64U}) {
    Region region = make_region(original, {}, {});
    const std::size_t target = original.triangles.size() / divisor;
    const Outcome outcome = simplify(region, target);
    EXPECT_EQ(outcome.initial_triangles, original.triangles.size());
    EXPECT_EQ(outcome.initial_vertices, original.vertices.size());
    EXPECT_EQ(outcome.locked_vertices, 0U);
    EXPECT_EQ(outcome.final_triangles, region.mesh.triangles.size());
    EXPECT_LE(outcome.final_triangles, target);
    EXPECT_GE(outcome.final_triangles + 2, target);  // each collapse takes two
    EXPECT_EQ(region.faces.size(), region.mesh.vertices.size());
    EXPECT_EQ(region.mesh.vertices.size() * 2,
              region.mesh.triangles.size() + 4);  // still a sphere, nothing unused
    expect_closed(region.mesh);
  }
}

TEST(Simplify, KeepsOuterFaceVerticesAndTheEdgesBetweenThem) {
  Region region = make_region(sphere(4, 0.005, 2), kInnerPlanes, kOuterPlanes);
  const Mesh before = region.mesh;
  std::vector<mesh::Vertex> kept;
  for (std::size_t v = 0; v < before.vertices.size(); ++v)
    if ((region.faces[v] & kOuterFace) != 0) kept.push_back(before.vertices[v]);
  ASSERT_GT(kept.size(), 100U);
  const auto is_border = [](const mesh::Edge& edge) { return edge.is_border(); };
  const auto border = edges_where(before, is_border);
  ASSERT_EQ(border.size(), kept.size());

  const Outcome outcome = simplify(region, 0);
  EXPECT_EQ(outcome.locked_vertices, kept.size());
  EXPECT_LT(region.mesh.triangles.size() * 4, before.triangles.size());
  std::vector<mesh::Vertex> found;
  for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v) {
    if ((region.faces[v] & kOuterFace) != 0) found.push_back(region.mesh.vertices[v]);
    EXPECT_EQ((region.faces[v] & kOuterFace) != 0,
              kOuterPlanes[0].side(region.mesh.vertices[v].position) == 0);
  }
  EXPECT_EQ(found, kept);
  EXPECT_EQ(edges_where(region.mesh, is_border), border);
}

TEST(Simplify, KeepsTrianglesInTheirCells) {
  for (const double noise : {0.0, 0.005, 0.03}) {
    Region region = make_region(sphere(4, noise, 3), kInnerPlanes, kOuterPlanes);
    expect_in_cells(region);
    for (int round = 0; round < 3; ++round) {
      simplify(region, region.mesh.triangles.size() / 2);
      expect_in_cells(region);
    }
    for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v)
      for (std::size_t i = 0; i < kInnerPlanes.size(); ++i)
        EXPECT_EQ((region.faces[v] >> i & 1) != 0,
                  kInnerPlanes[i].side(region.mesh.vertices[v].position) == 0);
  }
}

// Otherwise the two sides of a face would not fit together when they are simplified apart.
void expect_polylines_on_faces(const Region& region) {
  std::map<std::array<std::uint32_t, 2>, std::set<std::uint8_t>> cells;
  for (std::size_t i = 0; i < region.cells.size(); ++i) {
    const Triangle& t = region.mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k)
      cells[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}].insert(region.cells[i]);
  }
  for (const auto& [edge, around] : cells) {
    const bool is_on_face = (region.faces[edge[0]] & region.faces[edge[1]]) != 0;
    ASSERT_EQ(around.size(), is_on_face ? 2U : 1U);
  }
}

TEST(Simplify, MeetsInnerFacesInPolylinesOnlyAndStaysClosed) {
  for (const double noise : {0.0, 0.005, 0.03}) {
    Region region = make_region(sphere(4, noise, 4), kInnerPlanes, {});
    expect_closed(region.mesh);
    expect_polylines_on_faces(region);
    const std::size_t target = region.mesh.triangles.size() / 12;
    simplify(region, target);
    EXPECT_LT(region.mesh.triangles.size(), 2 * target);
    expect_closed(region.mesh);
    expect_polylines_on_faces(region);
  }
}

TEST(Simplify, TurnsNoTriangleOfASmoothSphereInward) {
  for (const bool has_cells : {false, true}) {
    Region region = make_region(sphere(4, 0.0, 5), has_cells ? kInnerPlanes : std::vector<Plane>{}, {});
    simplify(region, region.mesh.triangles.size() / 10);
    for (const Triangle& t : region.mesh.triangles) {
      const Vec3 a = at(region.mesh, t[0]);
      const Vec3 normal = geometry::cross(at(region.mesh, t[1]) - a, at(region.mesh, t[2]) - a);
      EXPECT_GT(geometry::dot(normal, a - kCenter), 0.0);
    }
  }
}

TEST(Simplify, KeepsTheStraightBorderOfAnOpenGridStraight) {
  const Mesh original = wavy_grid(50);
  Region region = make_region(original, kInnerPlanes, {});
  std::array<std::int32_t, 2> low{geometry::kRootSide, geometry::kRootSide};
  std::array<std::int32_t, 2> high{0, 0};
  for (const mesh::Vertex& vertex : original.vertices)
    for (int axis = 0; axis < 2; ++axis) {
      auto& least = low[static_cast<std::size_t>(axis)];
      auto& most = high[static_cast<std::size_t>(axis)];
      least = std::min(least, vertex.position[axis]);
      most = std::max(most, vertex.position[axis]);
    }
  std::set<Point> border_before;
  for (const PointEdge& edge : edges_where(region.mesh, [](const mesh::Edge& e) { return e.is_border(); }))
    border_before.insert(edge.begin(), edge.end());

  simplify(region, region.mesh.triangles.size() / 10);
  const auto after = mesh::edges(region.mesh.triangles);
  EXPECT_EQ(mesh::border_loop_count(after, region.mesh.vertices.size()), 1U);
  std::set<Point> border_after;
  for (const mesh::Edge& edge : after) {
    EXPECT_FALSE(edge.is_nonmanifold());
    if (!edge.is_border()) continue;
    const PointEdge ends = point_edge(region.mesh, edge);
    border_after.insert(ends.begin(), ends.end());
    bool is_on_line = false;
    for (int axis = 0; axis < 2; ++axis)
      for (const std::int32_t line :
           {low[static_cast<std::size_t>(axis)], high[static_cast<std::size_t>(axis)]})
        is_on_line |= ends[0][axis] == line && ends[1][axis] == line;
    EXPECT_TRUE(is_on_line);
  }
  EXPECT_LT(border_after.size() * 2, border_before.size());
  for (const Point& p : border_after) EXPECT_TRUE(border_before.contains(p));
}

// A sphere and its mirror image about one of its vertices.
Mesh bow_tie(std::uint32_t knot) {
  Mesh mesh = sphere(3, 0.002, 6);
  for (mesh::Vertex& vertex : mesh.vertices) vertex.position = geometry::midpoint(vertex.position, {});
  const Point center = mesh.vertices[knot].position;
  Mesh mirrored = mesh;
  for (mesh::Vertex& vertex : mirrored.vertices)
    for (int axis = 0; axis < 3; ++axis) vertex.position[axis] = 2 * center[axis] - vertex.position[axis];
  for (Triangle& t : mirrored.triangles) std::swap(t[1], t[2]);
  append(mesh, mirrored);
  mesh::weld(mesh);
  return mesh;
}

TEST(Simplify, KeepsABowTieVertex) {
  const std::uint32_t knot = 3 * 64;
  const Point position = geometry::midpoint(sphere(3, 0.002, 6).vertices[knot].position, {});
  Region region = make_region(bow_tie(knot), {}, {});
  const Outcome outcome = simplify(region, region.mesh.triangles.size() / 10);
  EXPECT_EQ(outcome.locked_vertices, 1U);
  EXPECT_LE(outcome.final_triangles, outcome.initial_triangles / 10);
  const auto is_nonmanifold = mesh::nonmanifold_vertices(region.mesh.triangles, region.mesh.vertices.size());
  for (std::size_t v = 0; v < region.mesh.vertices.size(); ++v)
    EXPECT_EQ(is_nonmanifold[v], region.mesh.vertices[v].position == position);
  EXPECT_EQ(std::count(is_nonmanifold.begin(), is_nonmanifold.end(), true), 1);
  expect_closed(region.mesh);
}

TEST(Simplify, KeepsTheEdgeOfThreeSheets) {
  // The grid, the grid mirrored at its first column, and the grid turned up around it.
  const Mesh grid = wavy_grid(24);
  Mesh sheets;
  for (int sheet = 0; sheet < 3; ++sheet) {
    Mesh copy = grid;
    const std::int32_t line = grid.vertices[0].position.x;
    for (mesh::Vertex& vertex : copy.vertices) {
      Point& p = vertex.position;
      const std::int32_t out = (p.x - line) / 4;
      p = sheet == 2 ? Point{kMiddle, p.y, p.z + out} : Point{kMiddle + (sheet == 0 ? out : -out), p.y, p.z};
    }
    if (sheet == 1)
      for (Triangle& t : copy.triangles) std::swap(t[1], t[2]);
    append(sheets, copy);
  }
  mesh::weld(sheets);
  Region region = make_region(sheets, {}, {});
  const auto is_nonmanifold = [](const mesh::Edge& edge) { return edge.is_nonmanifold(); };
  const auto before = edges_where(region.mesh, is_nonmanifold);
  ASSERT_EQ(before.size(), 24U);
  const Outcome outcome = simplify(region, sheets.triangles.size() / 8);
  EXPECT_LT(outcome.final_triangles, outcome.initial_triangles / 4);
  EXPECT_EQ(edges_where(region.mesh, is_nonmanifold), before);
}

TEST(Simplify, LeavesTheSmallestShapesAlone) {
  Mesh shapes;
  for (std::int32_t i = 0; i < 40; ++i) {
    const std::int32_t x = 8000 * i + 8;
    Mesh shape;
    for (const Point& p : {Point{x, 8, 8}, Point{x + 800, 8, 8}, Point{x, 808, 8}, Point{x + 80, 8, 808}})
      shape.vertices.push_back(vertex_at(p));
    shape.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    if (i % 2 == 1) shape = {{shape.vertices[0], shape.vertices[1], shape.vertices[2]}, {{0, 1, 2}}};
    append(shapes, shape);
  }
  Region region = make_region(shapes, {}, {});
  const Mesh before = region.mesh;
  simplify(region, 0);
  EXPECT_EQ(region.mesh.triangles, before.triangles);
  EXPECT_EQ(region.mesh.vertices, before.vertices);
}

TEST(Simplify, LeavesSomethingOfEverySphere) {
  Mesh spheres;
  for (int i = 0; i < 5; ++i) {
    Mesh small = sphere(2, 0.01, static_cast<std::uint64_t>(i));
    for (mesh::Vertex& vertex : small.vertices)
      for (int axis = 0; axis < 3; ++axis)
        vertex.position[axis] = vertex.position[axis] / 16 + (axis == 0 ? i * (kMiddle / 4) : 0);
    append(spheres, small);
  }
  Region region = make_region(spheres, {}, {});
  simplify(region, 0);
  expect_closed(region.mesh);
  EXPECT_LT(region.mesh.triangles.size(), spheres.triangles.size() / 4);
  std::array<std::set<std::uint32_t>, 5> left;
  for (std::uint32_t v = 0; v < region.mesh.vertices.size(); ++v)
    left.at(static_cast<std::size_t>(region.mesh.vertices[v].position.x / (kMiddle / 4))).insert(v);
  for (const auto& vertices : left) EXPECT_GE(vertices.size(), 4U);
}

// --- measured distances ---

void expect_samples_measured(const Region& region, const Outcome& outcome) {
  const BruteForce surface(region.mesh);
  mesh::Adjacency adjacency;
  adjacency.build(region.mesh.triangles, region.mesh.vertices.size());
  double farthest = 0.0;
  double truly_farthest = 0.0;
  for (const SurfaceSample& sample : region.samples) {
    const Vec3 p = geometry::to_vec3(sample.position);
    const double truth = surface.distance(p);
    const double said = static_cast<double>(sample.distance);
    // Rounding may lose what is below 1e-7 of a triangle.
    ASSERT_GE(said, truth * (1.0 - 1e-6) - 1e-8 * kRadius);
    farthest = std::max(farthest, said);
    truly_farthest = std::max(truly_farthest, truth);
    ASSERT_LT(sample.anchor, region.mesh.vertices.size());
    bool is_attached = false;
    for (const auto i : adjacency.around(sample.anchor)) {
      const Triangle& t = region.mesh.triangles[i];
      const double d =
          distance_to_triangle(p, at(region.mesh, t[0]), at(region.mesh, t[1]), at(region.mesh, t[2]));
      is_attached |= region.cells[i] == sample.cell && d <= said * (1.0 + 1e-6) + 1e-8 * kRadius;
    }
    ASSERT_TRUE(is_attached);
  }
  EXPECT_GT(truly_farthest, 0.0);
  EXPECT_GE(outcome.deviation, farthest);
  // Measured, not added up.
  EXPECT_LT(outcome.deviation, 4.0 * truly_farthest);
}

TEST(Deviation, IsNeverLessThanTheDistanceOfAnySample) {
  for (const bool has_border : {false, true}) {
    const Mesh original = has_border ? wavy_grid(40) : sphere(4, 0.005, 7);
    Region region = make_region(original, kInnerPlanes, {});
    const std::size_t sample_count = region.samples.size();
    // Samples of the input are carried along.
    for (int round = 0; round < 3; ++round) {
      SCOPED_TRACE(testing::Message() << "has_border " << has_border << ", round " << round);
      const Outcome outcome = simplify(region, region.mesh.triangles.size() / 2);
      EXPECT_EQ(region.samples.size(), sample_count);
      expect_samples_measured(region, outcome);
    }
  }
}

TEST(Deviation, ThinningOutKeepsTheFarthestInWhateverOrder) {
  constexpr std::uint64_t kSeed = 8;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::vector<SurfaceSample> samples;
  for (std::int32_t i = 0; i < 1000; ++i)
    samples.push_back({{i, static_cast<std::int32_t>(random() % 1000), 0},
                       static_cast<std::uint32_t>(random() % 50),
                       static_cast<float>(random() % 300),
                       0});
  std::vector<float> distances;
  for (const SurfaceSample& sample : samples) distances.push_back(sample.distance);
  std::sort(distances.begin(), distances.end(), std::greater<>());
  std::vector<SurfaceSample> shuffled = samples;
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  thin_out(samples, 200);
  thin_out(shuffled, 200);
  ASSERT_EQ(samples.size(), 200U);
  ASSERT_EQ(shuffled.size(), 200U);
  std::vector<float> left;
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_EQ(samples[i].position, shuffled[i].position);
    left.push_back(samples[i].distance);
  }
  std::sort(left.begin(), left.end(), std::greater<>());
  EXPECT_TRUE(std::equal(left.begin(), left.begin() + 50, distances.begin()));
  EXPECT_LT(left.back(), distances[200]);  // others are not chosen by distance
  thin_out(samples, 500);
  EXPECT_EQ(samples.size(), 200U);
}

TEST(Simplify, DoesTheSameTwice) {
  const Region start = make_region(sphere(4, 0.01, 9), kInnerPlanes, kOuterPlanes);
  Region first = start;
  Region second = start;
  const Outcome first_outcome = simplify(first, start.mesh.triangles.size() / 3);
  const Outcome second_outcome = simplify(second, start.mesh.triangles.size() / 3);
  EXPECT_EQ(first.mesh.vertices, second.mesh.vertices);
  EXPECT_EQ(first.mesh.triangles, second.mesh.triangles);
  EXPECT_EQ(first.faces, second.faces);
  EXPECT_EQ(first.cells, second.cells);
  EXPECT_EQ(first_outcome.deviation, second_outcome.deviation);
  ASSERT_EQ(first.samples.size(), second.samples.size());
  for (std::size_t i = 0; i < first.samples.size(); ++i) {
    EXPECT_EQ(first.samples[i].anchor, second.samples[i].anchor);
    EXPECT_EQ(first.samples[i].distance, second.samples[i].distance);
    EXPECT_EQ(first.samples[i].cell, second.samples[i].cell);
  }
}

TEST(VertexClass, TellsWhatAVertexMayDo) {
  const Region region = make_region(wavy_grid(10), kInnerPlanes, {});
  mesh::Adjacency adjacency;
  adjacency.build(region.mesh.triangles, region.mesh.vertices.size());
  std::vector<bool> is_on_border(region.mesh.vertices.size(), false);
  for (const mesh::Edge& edge : mesh::edges(region.mesh.triangles))
    if (edge.is_border()) is_on_border[edge.a] = is_on_border[edge.b] = true;
  const auto classes = classify_vertices(region, adjacency);
  for (std::size_t v = 0; v < classes.size(); ++v)
    EXPECT_EQ(classes[v], is_on_border[v]        ? VertexClass::kBorder
                          : region.faces[v] != 0 ? VertexClass::kFace
                                                 : VertexClass::kFree);
  Region outer = region;
  outer.outer_faces = 1;
  const auto locked = classify_vertices(outer, adjacency);
  for (std::size_t v = 0; v < locked.size(); ++v) {
    const bool is_outer = (region.faces[v] & 1) != 0;
    EXPECT_EQ(locked[v], is_outer ? VertexClass::kLocked : classes[v]);
  }
}

TEST(AngleCounts, CountEachTriangleBySmallestAngle) {
  // Legs 1000 and so wide that the smallest angles are about 2, 10, 20 and 45 degrees; the last has no area.
  Mesh mesh;
  for (const std::int32_t height : {35, 176, 364, 1000, 0}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Point& p : {Point{0, 0, 0}, Point{1000, 0, 0}, Point{0, height, 0}})
      mesh.vertices.push_back(vertex_at(p));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const AngleCounts counts = count_small_angles(mesh);
  EXPECT_EQ(counts.below_5_degrees, 2U);
  EXPECT_EQ(counts.below_15_degrees, 3U);
  EXPECT_EQ(counts.below_30_degrees, 4U);
}

// --- beside the reference ---

struct DoubleTraits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using ReferenceMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

Mesh decimated_by_open_mesh(const Mesh& mesh, std::size_t target_triangles) {
  ReferenceMesh reference;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3 p = at(mesh, v);
    reference.add_vertex({p.x, p.y, p.z});
  }
  for (const Triangle& t : mesh.triangles)
    reference.add_face(reference.vertex_handle(t[0]), reference.vertex_handle(t[1]),
                       reference.vertex_handle(t[2]));
  OpenMesh::Decimater::DecimaterT<ReferenceMesh> decimater(reference);
  OpenMesh::Decimater::ModQuadricT<ReferenceMesh>::Handle quadrics;
  decimater.add(quadrics);
  decimater.module(quadrics).unset_max_err();
  decimater.initialize();
  decimater.decimate_to_faces(0, target_triangles);
  reference.garbage_collection();
  Mesh result;
  for (const auto v : reference.vertices()) {
    const auto& p = reference.point(v);  // half-edge collapses: still lattice points
    result.vertices.push_back(vertex_at(
        {static_cast<std::int32_t>(p[0]), static_cast<std::int32_t>(p[1]), static_cast<std::int32_t>(p[2])}));
  }
  for (const auto f : reference.faces()) {
    Triangle triangle{};
    std::size_t corner = 0;
    for (const auto v : reference.fv_range(f)) triangle[corner++] = static_cast<std::uint32_t>(v.idx());
    result.triangles.push_back(triangle);
  }
  return result;
}

TEST(Simplify, IsNoFartherFromTheOriginalThanOpenMesh) {
  const Mesh original = sphere(4, 0.005, 10);
  for (const std::size_t divisor : {2U, 4U}) {
    const Mesh reference = decimated_by_open_mesh(original, original.triangles.size() / divisor);
    ASSERT_LE(reference.triangles.size(), original.triangles.size() / divisor + 2);
    Region region = make_region(original, {}, {});
    simplify(region, reference.triangles.size());
    ASSERT_LE(region.mesh.triangles.size(), reference.triangles.size());
    const double ours = rms_distance(region.mesh, original) / kRadius;
    const double theirs = rms_distance(reference, original) / kRadius;
    const double ours_back = rms_distance(original, region.mesh) / kRadius;
    const double theirs_back = rms_distance(original, reference) / kRadius;
    std::printf(
        "1/%zu: RMS to the original %.3e (OpenMesh %.3e), from it %.3e (OpenMesh %.3e) of the radius\n",
        divisor, ours, theirs, ours_back, theirs_back);
    EXPECT_LE(ours, theirs);
    EXPECT_LE(ours_back, theirs_back);
  }
}

}  // namespace
}  // namespace colossus::simplify
