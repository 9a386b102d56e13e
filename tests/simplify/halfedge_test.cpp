// Regions whose vertices may not be placed: what remains of two vertices is one of them, and where each has
// gone is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "mesh/adjacency.hpp"
#include "simplify/collapse.hpp"
#include "simplify/deviation.hpp"
#include "simplify/mesh_checks.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

constexpr std::uint64_t kSeeds = 6;
constexpr FaceMask kShared = 1;

// Closed or with a border; every vertex and triangle with attributes and a number of its own; the vertices
// in an eighth of space shared with others, but for `has_locked` false.
Region block(std::uint64_t seed, bool has_border, bool has_locked) {
  Region region = make_region(
      has_border ? rough_sheet(30, 30, 0.1 * static_cast<double>(seed % 5), seed) : sphere(3, 0.01, seed), {},
      {});
  std::mt19937_64 random(seed);
  for (mesh::Vertex& vertex : region.mesh.vertices) {
    vertex.normal = {static_cast<std::int16_t>(random()), static_cast<std::int16_t>(random()), 1};
    for (auto& channel : vertex.color) channel = static_cast<std::uint8_t>(random());
  }
  for (std::size_t i = 0; i < region.cells.size(); ++i) region.cells[i] = static_cast<std::uint16_t>(i % 512);
  for (SurfaceSample& sample : region.samples) sample.cell = 511;
  region.outer_faces = kShared;
  if (has_locked)
    for (std::size_t v = 0; v < region.faces.size(); ++v) {
      const Point& p = region.mesh.vertices[v].position;
      if (p.x > kMiddle && p.y > kMiddle) region.faces[v] = kShared;
    }
  region.cell_planes.clear();
  region.may_place = false;
  return region;
}

struct Simplified {
  Region before;
  Region after;
  Outcome outcome;
};

Simplified simplified(Region region, std::size_t target) {
  Simplified result;
  result.before = region;
  result.outcome = simplify(region, target);
  result.after = std::move(region);
  return result;
}

// Over seeds, closed and open, with locked vertices and without, colours weighed or not.
template <typename Check>
void for_each_block(const Check& check) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    for (const bool has_border : {false, true})
      for (const bool has_locked : {false, true})
        for (const double color_weight : {0.0, 1.0}) {
          SCOPED_TRACE(testing::Message() << "seed " << seed << ", border " << has_border << ", locked "
                                          << has_locked << ", color weight " << color_weight);
          Region region = block(seed, has_border, has_locked);
          region.color_weight = color_weight;
          check(region);
          if (testing::Test::HasFatalFailure()) return;
        }
}

std::int64_t max_norm(const Point& a, const Point& b) {
  std::int64_t greatest = 0;
  for (int axis = 0; axis < 3; ++axis)
    greatest = std::max(greatest, std::abs(std::int64_t{a[axis]} - std::int64_t{b[axis]}));
  return greatest;
}

std::int64_t greatest_move(const Simplified& of) {
  std::int64_t greatest = 0;
  for (std::size_t v = 0; v < of.outcome.representative.size(); ++v)
    greatest = std::max(greatest, max_norm(of.before.mesh.vertices[v].position,
                                           of.after.mesh.vertices[of.outcome.representative[v]].position));
  return greatest;
}

// The smallest corner first: the same for the same oriented triangle.
Triangle turned(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

using NumberedTriangles = std::multiset<std::pair<Triangle, std::uint16_t>>;

TEST(HalfEdge, LeavesVerticesOfTheInputWithTheirAttributesInOrder) {
  for_each_block([](const Region& region) {
    const Simplified r = simplified(region, region.mesh.triangles.size() / 4);
    ASSERT_LT(r.after.mesh.vertices.size(), r.before.mesh.vertices.size());
    std::size_t next = 0;
    for (const mesh::Vertex& vertex : r.after.mesh.vertices) {
      while (next < r.before.mesh.vertices.size() && r.before.mesh.vertices[next] != vertex) ++next;
      ASSERT_LT(next, r.before.mesh.vertices.size());
      // It has become itself.
      ASSERT_EQ(&r.after.mesh.vertices[r.outcome.representative[next]], &vertex);
      ASSERT_EQ(r.after.faces[r.outcome.representative[next]], r.before.faces[next]);
    }
  });
}

TEST(HalfEdge, MapsTheTrianglesBeforeOntoThoseAfter) {
  for_each_block([](const Region& region) {
    const Simplified r = simplified(region, region.mesh.triangles.size() / 4);
    ASSERT_EQ(r.outcome.representative.size(), r.before.mesh.vertices.size());
    NumberedTriangles mapped;
    for (std::size_t i = 0; i < r.before.mesh.triangles.size(); ++i) {
      Triangle t = r.before.mesh.triangles[i];
      for (auto& v : t) v = r.outcome.representative[v];
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mapped.emplace(turned(t), r.before.cells[i]);
    }
    NumberedTriangles after;
    for (std::size_t i = 0; i < r.after.mesh.triangles.size(); ++i)
      after.emplace(turned(r.after.mesh.triangles[i]), r.after.cells[i]);
    ASSERT_EQ(mapped, after);
  });
}

TEST(HalfEdge, MovesNoVertexBeyondItsReach) {
  for_each_block([](const Region& region) {
    const std::size_t target = region.mesh.triangles.size() / 8;
    const std::int64_t unlimited = greatest_move(simplified(region, target));
    for (const std::int64_t divisor : {2, 3, 5}) {
      Region limited = region;
      limited.reach = unlimited / divisor;
      const Simplified r = simplified(limited, target);
      ASSERT_LE(greatest_move(r), limited.reach);
      // Used, too.
      ASSERT_GT(2 * greatest_move(r), limited.reach);
    }
  });
}

TEST(HalfEdge, ReachIncludesItsEnd) {
  constexpr std::int32_t kStep = 1000;
  Mesh grid;
  for (std::int32_t i = 0; i <= 6; ++i)
    for (std::int32_t k = 0; k <= 6; ++k) grid.vertices.push_back(vertex_at({kStep * i, kStep * k, 0}));
  for (std::uint32_t i = 0; i < 6; ++i)
    for (std::uint32_t k = 0; k < 6; ++k) {
      const std::uint32_t v = 7 * i + k;
      grid.triangles.insert(grid.triangles.end(), {{v, v + 7, v + 8}, {v, v + 8, v + 1}});
    }
  Region region = make_region(grid, {}, {});
  region.may_place = false;
  for (const std::int64_t reach : {kStep - 1, kStep, 2 * kStep - 1, 2 * kStep}) {
    SCOPED_TRACE(testing::Message() << "reach " << reach);
    region.reach = reach;
    EXPECT_EQ(greatest_move(simplified(region, 2)), reach / kStep * kStep);
  }
}

TEST(HalfEdge, LeavesLockedVerticesAlone) {
  for_each_block([](const Region& region) {
    const Simplified r = simplified(region, 0);
    std::map<std::uint32_t, int> locked;
    for (std::size_t v = 0; v < region.faces.size(); ++v) {
      if (region.faces[v] != kShared) continue;
      const std::uint32_t to = r.outcome.representative[v];
      ASSERT_EQ(r.after.mesh.vertices[to], r.before.mesh.vertices[v]);
      ASSERT_EQ(++locked[to], 1);
    }
    ASSERT_LE(locked.size(), r.outcome.locked_vertices);
    // Others collapse around them.
    ASSERT_LT(r.after.mesh.vertices.size(), r.before.mesh.vertices.size() * 3 / 5);
  });
}

TEST(HalfEdge, LocksNoPairOfSharedVerticesIntoANewEdge) {
  // Another block could make the same edge on its side: four triangles.
  for_each_block([](const Region& region) {
    const Simplified r = simplified(region, 0);
    const auto is_shared = [](const Region& of) {
      return [&of](const mesh::Edge& edge) { return (of.faces[edge.a] & of.faces[edge.b]) != 0; };
    };
    ASSERT_EQ(edges_where(r.before.mesh, is_shared(r.before)), edges_where(r.after.mesh, is_shared(r.after)));
  });
}

TEST(HalfEdge, KeepsASurfaceClosedAndManifold) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    for (const bool has_locked : {false, true})
      for (const double color_weight : {0.0, 1.0})
        for (const std::int64_t reach : {std::int64_t{kMiddle}, std::int64_t{kMiddle / 20}}) {
          SCOPED_TRACE(testing::Message() << "seed " << seed << ", locked " << has_locked << ", color weight "
                                          << color_weight << ", reach " << reach);
          Region region = block(seed, false, has_locked);
          region.color_weight = color_weight;
          region.reach = reach;
          const Simplified r = simplified(region, 0);
          expect_closed(r.after.mesh);
          const std::vector<bool> nonmanifold = nonmanifold_vertices(r.after.mesh);
          EXPECT_EQ(std::count(nonmanifold.begin(), nonmanifold.end(), true), 0);
          EXPECT_EQ(r.after.mesh.vertices.size() * 2, r.after.mesh.triangles.size() + 4);
        }
}

TEST(HalfEdge, PinchesNoThinTube) {
  // Rings of three vertices: the edges of a ring are no triangle, so none may collapse.
  constexpr std::uint32_t kRings = 40;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> shift(-1.0, 1.0);
    Mesh tube;
    for (std::uint32_t ring = 0; ring < kRings; ++ring)
      for (const Vec3& corner : {Vec3{0, 0, 0}, {0, 100, 0}, {0, 0, 100}}) {
        const Vec3 along{100'000.0 * ring + 20'000.0 * shift(random), 10.0 * shift(random),
                         10.0 * shift(random)};
        const Vec3 p = corner + along;
        tube.vertices.push_back(vertex_at({static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y),
                                           static_cast<std::int32_t>(p.z)}));
      }
    for (std::uint32_t v = 0; v < 3 * (kRings - 1); ++v) {
      const std::uint32_t next = v % 3 == 2 ? v - 2 : v + 1;
      tube.triangles.insert(tube.triangles.end(), {{v, next, v + 3}, {next, next + 3, v + 3}});
    }
    tube.triangles.insert(tube.triangles.end(),
                          {{2, 1, 0}, {3 * kRings - 3, 3 * kRings - 2, 3 * kRings - 1}});
    Region region = make_region(tube, {}, {});
    region.may_place = false;
    const Simplified r = simplified(region, 0);
    EXPECT_LT(r.after.mesh.triangles.size(), tube.triangles.size());
    expect_closed(r.after.mesh);
    const std::vector<bool> nonmanifold = nonmanifold_vertices(r.after.mesh);
    EXPECT_EQ(std::count(nonmanifold.begin(), nonmanifold.end(), true), 0);
  }
}

// Whether a may become b on a closed mesh, seen from what comes of it: manifold, and no triangle turned by
// 78 degrees, with a margin.
bool is_clearly_legal(const Mesh& mesh, const mesh::Adjacency& adjacency, std::uint32_t a, std::uint32_t b) {
  const auto neighbours = [&](std::uint32_t v) {
    std::set<std::uint32_t> found;
    for (const auto i : adjacency.around(v)) found.insert(mesh.triangles[i].begin(), mesh.triangles[i].end());
    found.erase(a);
    found.erase(b);
    return found;
  };
  const std::set<std::uint32_t> of_a = neighbours(a);
  const std::set<std::uint32_t> of_b = neighbours(b);
  std::vector<std::uint32_t> common;
  std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), std::back_inserter(common));
  if (common.size() != 2) return false;
  for (const auto apex : common)
    if (adjacency.around(apex).size() <= 3) return false;
  for (const auto i : adjacency.around(a)) {
    Triangle t = mesh.triangles[i];
    if (std::count(t.begin(), t.end(), b) > 0) continue;
    const auto normal = [&] {
      return geometry::cross(at(mesh, t[1]) - at(mesh, t[0]), at(mesh, t[2]) - at(mesh, t[0]));
    };
    const Vec3 old_normal = normal();
    std::replace(t.begin(), t.end(), a, b);
    const Vec3 new_normal = normal();
    if (geometry::dot(old_normal, new_normal) <
        0.21 * geometry::length(old_normal) * geometry::length(new_normal))
      return false;
  }
  return true;
}

TEST(HalfEdge, LeavesNoLegalCollapseUntriedAtEitherEnd) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    // So rough that the cheaper end is often illegal.
    Region region = make_region(sphere(3, 0.15, seed), {}, {});
    region.may_place = false;
    region.reach = kMiddle / 8;
    const Simplified r = simplified(region, 0);
    const Mesh& mesh = r.after.mesh;
    mesh::Adjacency adjacency;
    adjacency.build(mesh.triangles, mesh.vertices.size());
    std::vector<std::vector<Point>> merged(mesh.vertices.size());
    for (std::size_t v = 0; v < r.outcome.representative.size(); ++v)
      merged[r.outcome.representative[v]].push_back(r.before.mesh.vertices[v].position);
    for (const mesh::Edge& edge : mesh::edges(mesh.triangles))
      for (const auto& [a, b] : {std::pair{edge.a, edge.b}, std::pair{edge.b, edge.a}}) {
        const Point& to = mesh.vertices[b].position;
        const bool is_within = std::all_of(merged[a].begin(), merged[a].end(),
                                           [&](const Point& p) { return max_norm(p, to) <= region.reach; });
        EXPECT_FALSE(is_within && is_clearly_legal(mesh, adjacency, a, b)) << a << " to " << b;
      }
  }
}

TEST(HalfEdge, DoesTheSameTwice) {
  for_each_block([](Region region) {
    region.reach = kMiddle / 20;
    const Simplified first = simplified(region, region.mesh.triangles.size() / 4);
    const Simplified second = simplified(region, region.mesh.triangles.size() / 4);
    ASSERT_EQ(first.after.mesh.vertices, second.after.mesh.vertices);
    ASSERT_EQ(first.after.mesh.triangles, second.after.mesh.triangles);
    ASSERT_EQ(first.after.cells, second.after.cells);
    ASSERT_EQ(first.outcome.representative, second.outcome.representative);
    ASSERT_EQ(first.outcome.deviation, second.outcome.deviation);
  });
}

TEST(HalfEdge, KeepsVerticesWithoutTriangles) {
  Region region = block(1, false, false);
  // The first, a middle one, and the last.
  for (const std::size_t place : {std::size_t{0}, std::size_t{100}, region.mesh.vertices.size()}) {
    const auto at = static_cast<std::ptrdiff_t>(place);
    region.mesh.vertices.insert(region.mesh.vertices.begin() + at,
                                vertex_at({static_cast<std::int32_t>(place) + 5, 1, 1}));
    region.faces.insert(region.faces.begin() + at, 0);
    for (Triangle& t : region.mesh.triangles)
      for (auto& v : t) v += v >= place ? 1U : 0U;
    for (SurfaceSample& sample : region.samples) sample.anchor += sample.anchor >= place ? 1U : 0U;
  }
  const Simplified r = simplified(region, region.mesh.triangles.size() / 4);
  for (const std::size_t place : {std::size_t{0}, std::size_t{100}, region.mesh.vertices.size() - 1})
    EXPECT_EQ(r.after.mesh.vertices.at(r.outcome.representative[place]), r.before.mesh.vertices[place]);
  EXPECT_EQ(r.outcome.representative[0], 0U);
  EXPECT_EQ(r.outcome.representative.back(), r.after.mesh.vertices.size() - 1);
  std::set<std::uint32_t> used;
  for (const Triangle& t : r.after.mesh.triangles) used.insert(t.begin(), t.end());
  EXPECT_EQ(r.after.mesh.vertices.size(), used.size() + 3);
}

TEST(HalfEdge, MeasuresSamplesOfAnchorsWithoutTriangles) {
  Mesh before;
  for (const Point& p : {Point{0, 0, 0}, {900, 0, 0}, {0, 900, 0}, {5000, 0, 0}})
    before.vertices.push_back(vertex_at(p));
  before.triangles = {{0, 1, 2}};
  const std::vector<std::uint32_t> same{0, 1, 2, 3};
  const std::vector<std::uint16_t> cells{300};
  std::vector<SurfaceSample> samples{{{10, 20, 70}, 3, 0.0F, 7}};
  EXPECT_EQ(measure_deviation(before, before, cells, same, false, samples).of_samples, 70.0);
  EXPECT_EQ(samples[0].anchor, 0U);
  EXPECT_EQ(samples[0].cell, 300U);

  Mesh vertices_only = before;
  vertices_only.triangles.clear();
  samples = {{{5000, 30, 40}, 1, 0.0F, 7}};
  const std::vector<std::uint32_t> to_last{3, 3, 3, 3};
  EXPECT_EQ(measure_deviation(before, vertices_only, {}, to_last, true, samples).greatest(), 50.0);
  EXPECT_EQ(samples[0].anchor, 3U);
  EXPECT_EQ(samples[0].distance, 50.0F);
  EXPECT_EQ(samples[0].cell, 7U);
}

}  // namespace
}  // namespace colossus::simplify
