#include "geometry/polygon.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <utility>

namespace colossus::geometry {
namespace {

using Wide = __int128;
using Flat = std::array<std::int64_t, 2>;
using Outline = std::vector<Flat>;
using Corners = std::vector<Point>;
using Triangle = std::array<std::uint32_t, 3>;
using Random = std::mt19937_64;

// ---- outlines in the plane, to the left of which they are inside

std::int64_t turn(const Flat& a, const Flat& b, const Flat& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

std::int64_t between(Random& random, std::int64_t low, std::int64_t high) {
  return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
}

int sign(std::int64_t x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

bool lies_on(const Flat& p, const Flat& a, const Flat& b) {
  return turn(a, b, p) == 0 && std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) &&
         std::min(a[1], b[1]) <= p[1] && p[1] <= std::max(a[1], b[1]);
}

bool meet(const Flat& a, const Flat& b, const Flat& c, const Flat& d) {
  if (sign(turn(a, b, c)) * sign(turn(a, b, d)) < 0 && sign(turn(c, d, a)) * sign(turn(c, d, b)) < 0)
    return true;
  return lies_on(a, c, d) || lies_on(b, c, d) || lies_on(c, a, b) || lies_on(d, a, b);
}

bool is_simple(const Outline& outline) {
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const Flat &a = outline[i], &b = outline[(i + 1) % n], &c = outline[j], &d = outline[(j + 1) % n];
      if (j == i + 1) {
        if (a == b || lies_on(d, a, b) || lies_on(a, c, d)) return false;
      } else if ((j + 1) % n == i) {
        if (c == d || lies_on(c, a, b) || lies_on(b, c, d)) return false;
      } else if (meet(a, b, c, d)) {
        return false;
      }
    }
  return true;
}

Wide double_area(const Outline& outline) {
  Wide area = 0;
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) area += turn(outline[0], outline[i], outline[i + 1]);
  return area;
}

constexpr double kTurn = 2 * std::numbers::pi;

Outline star(Random& random, int count, double least, double radius) {
  Outline outline;
  for (int i = 0; i < count; ++i) {
    const double r = radius * std::uniform_real_distribution<double>(least, 1.0)(random);
    outline.push_back(
        {std::llround(r * std::cos(kTurn * i / count)), std::llround(r * std::sin(kTurn * i / count))});
  }
  return outline;
}

Outline gear(int count, double radius) {
  Outline outline;
  for (int i = 0; i < count; ++i) {
    const double r = i % 2 == 0 ? radius : 0.999 * radius;
    outline.push_back(
        {std::llround(r * std::cos(kTurn * i / count)), std::llround(r * std::sin(kTurn * i / count))});
  }
  return outline;
}

// A band that winds inward, and comes back along its other side.
Outline spiral(int count, double turns, double radius) {
  Outline outline;
  const int half = count / 2;
  for (int i = 0; i < count; ++i) {
    const int k = i < half ? i : count - 1 - i;
    const double r = radius * (0.1 + 0.8 * k / half) - (i < half ? 0.0 : radius * 0.8 / turns * 0.4);
    const double a = kTurn * turns * k / half;
    outline.push_back({std::llround(r * std::cos(a)), std::llround(r * std::sin(a))});
  }
  return outline;
}

// Teeth of different lengths upwards from a bar.
Outline comb(Random& random, int teeth, std::int64_t width, std::int64_t height) {
  Outline outline{{0, -width}, {2 * teeth * width, -width}};
  for (int i = teeth; i-- > 0;) {
    const std::int64_t top = between(random, height / 2, height);
    outline.push_back({(2 * i + 2) * width, 0});
    outline.push_back({(2 * i + 1) * width + width / 2, top});
    outline.push_back({(2 * i + 1) * width, top - 1});
    outline.push_back({(2 * i + 1) * width, 0});
  }
  return outline;
}

// Random corners, untangled by turning round the way between two edges that meet.
Outline untangled(Random& random, int count, std::int64_t reach) {
  std::set<Flat> corners;
  while (std::ssize(corners) < count) corners.insert({between(random, 0, reach), between(random, 0, reach)});
  Outline outline(corners.begin(), corners.end());
  std::shuffle(outline.begin(), outline.end(), random);
  for (int round = 0; round < 20 * count; ++round) {
    bool was_tangled = false;
    for (int i = 0; i < count; ++i)
      for (int j = i + 2; j < count; ++j) {
        const auto at = [&](int k) { return outline[static_cast<std::size_t>(k % count)]; };
        if ((j + 1) % count == i || !meet(at(i), at(i + 1), at(j), at(j + 1))) continue;
        std::reverse(outline.begin() + i + 1, outline.begin() + j + 1);
        was_tangled = true;
      }
    if (!was_tangled) break;
  }
  if (double_area(outline) < 0) std::reverse(outline.begin(), outline.end());
  return outline;
}

// Squares of a board glued to each other one by one, along one side each: what lies between squares that are
// beside each other but not glued is run through twice, rings are closed by a bridge, and corners meet in one
// place. A hair that is left in the middle goes with `is_combed`.
Outline glued(Random& random, int squares, std::int64_t size, bool is_combed) {
  Outline outline{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  std::set<Flat> taken{{0, 0}};  // lower left corners
  const std::int64_t reach = std::max<std::int64_t>(2, static_cast<std::int64_t>(std::sqrt(squares)));
  for (int tries = 0; tries < 100 * squares && std::ssize(taken) < squares; ++tries) {
    const std::size_t i = random() % outline.size();
    const Flat p = outline[i];
    const Flat q = outline[(i + 1) % outline.size()];
    const Flat out{q[1] - p[1], p[0] - q[0]};
    const Flat r{p[0] + out[0], p[1] + out[1]};
    const Flat s{q[0] + out[0], q[1] + out[1]};
    const Flat square{std::min({p[0], q[0], r[0]}), std::min({p[1], q[1], r[1]})};
    if (std::abs(square[0]) > reach || std::abs(square[1]) > reach || !taken.insert(square).second) continue;
    outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(i) + 1, {r, s});
    for (std::size_t k = 0; is_combed && outline.size() > 4 && k < outline.size(); ++k)
      if (outline[k] == outline[(k + 2) % outline.size()] && random() % 2 == 0) {
        std::rotate(outline.begin(), outline.begin() + static_cast<std::ptrdiff_t>(k), outline.end());
        outline.erase(outline.begin() + 1, outline.begin() + 3);
      }
  }
  for (Flat& p : outline) p = {p[0] * size, p[1] * size};
  return outline;
}

// ---- into space

Corners on_floor(const Outline& outline) {
  Corners corners;
  for (const Flat& p : outline)
    corners.push_back({static_cast<std::int32_t>(p[0] + kRootSide / 2),
                       static_cast<std::int32_t>(p[1] + kRootSide / 2), 77});
  return corners;
}

// Exactly in a plane: whole multiples of two whole vectors. Coordinates up to `reach` in the outline.
Corners in_plane(Random& random, const Outline& outline, std::int64_t reach) {
  const std::int64_t most = kRootSide / 4 / reach;
  std::array<std::int64_t, 3> a{};
  std::array<std::int64_t, 3> b{};
  do {
    for (std::int64_t& x : a) x = between(random, -most, most);
    for (std::int64_t& x : b) x = between(random, -most, most);
  } while (a[0] * b[1] == a[1] * b[0] && a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2]);
  Corners corners;
  for (const Flat& p : outline) {
    Point q;
    for (int k = 0; k < 3; ++k)
      q[k] = static_cast<std::int32_t>(kRootSide / 2 + p[0] * a[static_cast<std::size_t>(k)] +
                                       p[1] * b[static_cast<std::size_t>(k)]);
    corners.push_back(q);
  }
  return corners;
}

// In a turned plane, each corner rounded to a multiple of eight.
Corners in_rounded_plane(Random& random, const Outline& outline) {
  std::normal_distribution<double> normal;
  std::array<double, 3> a{normal(random), normal(random), normal(random)};
  std::array<double, 3> b{normal(random), normal(random), normal(random)};
  const auto dot = [](const auto& x, const auto& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
  const auto make_unit = [&](auto& x) {
    const double length = std::sqrt(dot(x, x));
    for (double& component : x) component /= length;
  };
  make_unit(a);
  const double along = dot(a, b);
  for (std::size_t k = 0; k < 3; ++k) b[k] -= along * a[k];
  make_unit(b);
  Corners corners;
  for (const Flat& p : outline) {
    Point q;
    for (int k = 0; k < 3; ++k)
      q[k] = kRootSide / 2 + 8 * static_cast<std::int32_t>(std::llround(
                                     (static_cast<double>(p[0]) * a[static_cast<std::size_t>(k)] +
                                      static_cast<double>(p[1]) * b[static_cast<std::size_t>(k)]) /
                                     8));
    corners.push_back(q);
  }
  return corners;
}

// ---- what must hold

// Each edge of the polygon in one triangle and in its direction, each other one once in both directions.
::testing::AssertionResult keeps_edges(const Corners& corners, std::span<const Triangle> triangles) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  if (triangles.size() != count - 2)
    return ::testing::AssertionFailure() << triangles.size() << " triangles of " << count;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(t[k], t[(k + 1) % 3]);
  for (std::uint32_t i = 0; i < count; ++i) edges.emplace_back((i + 1) % count, i);  // the rest of the mesh
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto [a, b] = edges[i];
    if (a >= count || b >= count || a == b) return ::testing::AssertionFailure() << "edge " << a << " " << b;
    if (i > 0 && edges[i - 1] == edges[i])
      return ::testing::AssertionFailure() << "edge " << a << " " << b << " twice";
    if (!std::binary_search(edges.begin(), edges.end(), std::pair(b, a)))
      return ::testing::AssertionFailure() << "edge " << a << " " << b << " is open";
  }
  return ::testing::AssertionSuccess();
}

Outline seen_along(int axis, const Corners& corners) {
  Outline seen;
  for (const Point& p : corners) seen.push_back({p[(axis + 1) % 3], p[(axis + 2) % 3]});
  if (double_area(seen) < 0)
    for (Flat& p : seen) std::swap(p[0], p[1]);
  return seen;
}

// The projection, by the book: where the area is greatest.
Outline seen_along_its_plane(const Corners& corners) {
  Outline best = seen_along(2, corners);
  for (const int axis : {1, 0}) {
    Outline seen = seen_along(axis, corners);
    if (double_area(seen) > double_area(best)) best = std::move(seen);
  }
  return best;
}

struct Cover {
  Wide area = 0;      // of the triangles, absolute
  Wide expected = 0;  // of the polygon
  int turned_over = 0;
  int collinear = 0;
};

Cover cover(const Outline& seen, std::span<const Triangle> triangles) {
  Cover found{.area = 0, .expected = double_area(seen), .turned_over = 0, .collinear = 0};
  for (const Triangle& t : triangles) {
    const std::int64_t area = turn(seen[t[0]], seen[t[1]], seen[t[2]]);
    found.area += std::abs(area);
    found.turned_over += area < 0;
    found.collinear += area == 0;
  }
  return found;
}

bool is_fan(std::span<const Triangle> triangles) {
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    if (triangles[i] != Triangle{0, i + 1, i + 2}) return false;
  return true;
}

class Polygon : public ::testing::Test {
 protected:
  // Covered exactly; `is_proper`: without a collinear triangle.
  PolygonKind expect_covered(const Corners& corners, bool is_proper) {
    const auto [kind, triangles] = triangulator_.triangulate(corners);
    EXPECT_TRUE(keeps_edges(corners, triangles));
    const Cover found = cover(seen_along_its_plane(corners), triangles);
    EXPECT_EQ(found.turned_over, 0);
    EXPECT_TRUE(found.area == found.expected);
    EXPECT_NE(kind, PolygonKind::kCrossing);
    if (kind == PolygonKind::kConvex) {
      EXPECT_TRUE(is_fan(triangles));
    } else if (is_proper) {
      EXPECT_EQ(found.collinear, 0);
    }
    return kind;
  }

  // From every corner (of the larger ones, some), and the other way round.
  void expect_covered_all_ways(Corners corners, bool is_proper) {
    const std::size_t step = corners.size() < 40 ? 1 : corners.size() / 7;
    for (const bool is_turned : {false, true}) {
      for (std::size_t first = 0; first < corners.size(); first += step) {
        Corners moved = corners;
        std::rotate(moved.begin(), moved.begin() + static_cast<std::ptrdiff_t>(first), moved.end());
        expect_covered(moved, is_proper);
        if (HasFailure()) {
          print(moved, is_turned, first);
          return;
        }
      }
      std::reverse(corners.begin(), corners.end());
    }
  }

  void expect_edges_all_ways(Corners corners) {
    for (const bool is_turned : {false, true}) {
      for (std::size_t first = 0; first < std::min<std::size_t>(corners.size(), 12); ++first) {
        Corners moved = corners;
        std::rotate(moved.begin(), moved.begin() + static_cast<std::ptrdiff_t>(first), moved.end());
        const auto [kind, triangles] = triangulator_.triangulate(moved);
        ASSERT_TRUE(keeps_edges(moved, triangles));
        const bool is_covered = cover(seen_along_its_plane(moved), triangles).turned_over == 0;
        bool is_covered_elsewhere = false;
        for (const int axis : {0, 1, 2}) {
          const Cover found = cover(seen_along(axis, moved), triangles);
          is_covered_elsewhere |= found.expected > 0 && found.turned_over == 0;
        }
        if (kind == PolygonKind::kConvex) {
          ASSERT_TRUE(is_covered && is_fan(triangles)) << is_turned;
        } else {
          ASSERT_TRUE(is_covered || is_covered_elsewhere || kind == PolygonKind::kCrossing) << is_turned;
          covered_elsewhere_ += !is_covered && is_covered_elsewhere;
        }
      }
      std::reverse(corners.begin(), corners.end());
    }
  }

  // On the floor, and in planes.
  void expect_simple(Random& random, const Outline& outline, bool is_proper = true) {
    std::int64_t reach = 1;
    for (const Flat& p : outline) reach = std::max({reach, std::abs(p[0]), std::abs(p[1])});
    expect_covered_all_ways(on_floor(outline), is_proper);
    for (int plane = 0; plane < 3 && !HasFailure(); ++plane)
      expect_covered_all_ways(in_plane(random, outline, reach), is_proper);
  }

  void print(const Corners& corners, bool is_turned, std::size_t first) {
    std::string text;
    for (const Point& p : corners)
      if (text.size() < 3000)
        text += "{" + std::to_string(p.x) + "," + std::to_string(p.y) + "," + std::to_string(p.z) + "},";
    ADD_FAILURE() << corners.size() << " corners, turned " << is_turned << ", first " << first << ": "
                  << text;
  }

  PolygonTriangulator triangulator_;
  int covered_elsewhere_ = 0;  // in another projection than that along their plane
};

TEST_F(Polygon, ConvexOnesAreTheFanFromTheFirstCorner) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const int count = static_cast<int>(between(random, 3, 40));
    Outline outline = star(random, count, 1.0, 8000);  // on a circle
    // Corners on the sides, and corners in one place.
    for (int k = 0; k < static_cast<int>(seed % 5); ++k) {
      const std::size_t i = random() % outline.size();
      const Flat a = outline[i];
      const Flat b = outline[(i + 1) % outline.size()];
      const Flat middle{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
      outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                     turn(a, b, middle) == 0 ? middle : a);
    }
    for (int turns = 0; turns < 2; ++turns) {
      const Corners corners = in_plane(random, outline, 8000);
      EXPECT_EQ(expect_covered(corners, false), PolygonKind::kConvex);
      if (count > 4) {
        // Much wider than what rounding moves.
        Outline wide = outline;
        for (Flat& p : wide) p = {p[0] * 10000, p[1] * 10000};
        if (seed % 5 == 0) {
          EXPECT_EQ(expect_covered(in_rounded_plane(random, wide), false), PolygonKind::kConvex);
        }
      }
      std::reverse(outline.begin(), outline.end());
    }
    ASSERT_FALSE(HasFailure());
  }
}

TEST_F(Polygon, AConcaveQuadIsTheFanFromItsReflexCorner) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Outline outline;
    do {
      outline.clear();
      for (int i = 0; i < 4; ++i) outline.push_back({between(random, 0, 20), between(random, 0, 20)});
    } while (!is_simple(outline) || double_area(outline) < 0);
    std::uint32_t reflex = 4;
    for (std::uint32_t i = 0; i < 4; ++i)
      if (turn(outline[(i + 3) % 4], outline[i], outline[(i + 1) % 4]) < 0) reflex = i;
    const Corners corners = in_plane(random, outline, 20);
    const auto [kind, triangles] = triangulator_.triangulate(corners);
    EXPECT_EQ(kind, reflex == 4 ? PolygonKind::kConvex : PolygonKind::kConcave);
    for (const Triangle& t : triangles) {
      EXPECT_NE(std::count(t.begin(), t.end(), reflex == 4 ? 0 : reflex), 0);
    }
    if (reflex % 2 == 0) {
      EXPECT_TRUE(is_fan(triangles)) << "as it was before";
    } else {
      EXPECT_EQ(triangles[0][0], reflex);
      EXPECT_EQ(triangles[1][0], reflex);
    }
    expect_simple(random, outline);
    ASSERT_FALSE(HasFailure());
  }
}

TEST_F(Polygon, SimpleOnesAreCovered) {
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const int count = static_cast<int>(between(random, 4, seed % 10 == 0 ? 90 : 24));
    for (const Outline& outline :
         {star(random, count, 0.1, 8000), untangled(random, count, 8000), untangled(random, count, 12),
          comb(random, count / 4 + 1, 20, 500), spiral(2 * count, 1 + count / 12, 8000)}) {
      if (!is_simple(outline)) continue;
      expect_simple(random, outline);
      ASSERT_FALSE(HasFailure());
    }
  }
}

TEST_F(Polygon, RoundedOnesAreCovered) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const int count = static_cast<int>(between(random, 5, 30));
    for (const Outline& outline : {star(random, count, 0.4, 1e6), comb(random, count / 4 + 1, 5000, 50000),
                                   spiral(2 * count, 1 + count / 12, 1e7)}) {
      if (!is_simple(outline)) continue;
      expect_covered_all_ways(in_rounded_plane(random, outline), false);
      ASSERT_FALSE(HasFailure());
    }
    // Corners in one place stay there, but flat corners turn to either side.
    expect_covered_all_ways(in_rounded_plane(random, glued(random, count, 4000, seed % 2 == 0)), false);
    ASSERT_FALSE(HasFailure());
  }
}

TEST_F(Polygon, OutlinesOfSquaresWithSlitsAndBridgesAreCovered) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const int squares = static_cast<int>(between(random, 1, seed % 10 == 0 ? 300 : 20));
    const Outline outline = glued(random, squares, 5, seed % 2 == 0);
    expect_simple(random, outline);
    ASSERT_FALSE(HasFailure());
  }
}

TEST_F(Polygon, HolesJoinedByABridge) {
  const Outline outer{{0, 0}, {40, 0}, {40, 40}, {20, 30}, {0, 40}};
  const Outline hole{{10, 10}, {10, 20}, {20, 20}, {20, 10}};
  for (std::size_t at = 0; at < outer.size(); ++at)
    for (const std::size_t from : {0U, 1U, 2U, 3U}) {
      // Only bridges that cross neither.
      bool is_clear = true;
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t j = (i + 1) % 4;
        if (i != from && j != from) is_clear &= !meet(outer[at], hole[from], hole[i], hole[j]);
      }
      for (std::size_t i = 0; i < 5; ++i) {
        const std::size_t j = (i + 1) % 5;
        if (i != at && j != at) is_clear &= !meet(outer[at], hole[from], outer[i], outer[j]);
      }
      if (!is_clear) continue;
      Outline outline(outer.begin(), outer.begin() + static_cast<std::ptrdiff_t>(at) + 1);
      for (std::size_t i = 0; i <= 4; ++i) outline.push_back(hole[(from + i) % 4]);
      outline.insert(outline.end(), outer.begin() + static_cast<std::ptrdiff_t>(at), outer.end());
      Random random(at * 4 + from);
      EXPECT_EQ(expect_covered(on_floor(outline), true), PolygonKind::kConcave);
      expect_simple(random, outline);
    }
}

TEST_F(Polygon, CornersInOnePlaceAndSpikesAddNothing) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Outline outline = untangled(random, static_cast<int>(between(random, 4, 16)), 200);
    if (!is_simple(outline)) continue;
    for (int k = 0; k < 3; ++k) {
      const std::size_t i = random() % outline.size();
      const Flat p = outline[i];
      const Flat q = outline[(i + 1) % outline.size()];
      const auto at = outline.begin() + static_cast<std::ptrdiff_t>(i) + 1;
      if (random() % 2 == 0)
        outline.insert(at, p);
      else  // there and back again along the edge, and once more
        outline.insert(at, {q, p});
    }
    expect_simple(random, outline, false);
    ASSERT_FALSE(HasFailure());
  }
}

TEST_F(Polygon, SpikesThatStickOut) {
  const Outline outline{{0, 0},   {20, 0},  {20, -30}, {20, 0},  {40, 0}, {40, 20},
                        {60, 40}, {40, 20}, {40, 40},  {10, 20}, {0, 40}};
  Random random(1);
  expect_simple(random, outline, false);
}

TEST_F(Polygon, FlatCornersKeepTheirEdgesAndNoTriangleIsCollinear) {
  // An L with corners on every side.
  Outline outline;
  const Outline l{{0, 0}, {60, 0}, {60, 20}, {20, 20}, {20, 60}, {0, 60}};
  for (std::size_t i = 0; i < l.size(); ++i)
    for (std::int64_t k = 0; k < 5; ++k) {
      const Flat a = l[i];
      const Flat b = l[(i + 1) % l.size()];
      outline.push_back({a[0] + (b[0] - a[0]) * k / 5, a[1] + (b[1] - a[1]) * k / 5});
    }
  Random random(1);
  expect_simple(random, outline);
  EXPECT_EQ(expect_covered(on_floor(outline), true), PolygonKind::kConcave);
}

TEST_F(Polygon, WithoutAreaTheyAreTheFan) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Point origin{1000000, 2000000, 3000000};
    const std::array<std::int32_t, 3> along{static_cast<std::int32_t>(between(random, -9, 9)),
                                            static_cast<std::int32_t>(between(random, -9, 9)),
                                            static_cast<std::int32_t>(seed % 3 == 0 ? 0 : 1)};
    Corners corners;
    for (int i = static_cast<int>(between(random, 3, 12)); i > 0; --i) {
      const auto k = static_cast<std::int32_t>(seed == 1 ? 0 : between(random, -5, 5));
      corners.push_back({origin.x + k * along[0], origin.y + k * along[1], origin.z + k * along[2]});
    }
    const auto [kind, triangles] = triangulator_.triangulate(corners);
    EXPECT_TRUE(keeps_edges(corners, triangles));
    EXPECT_TRUE(is_fan(triangles));
    EXPECT_EQ(kind, PolygonKind::kConvex);
  }
}

TEST_F(Polygon, CrossingOnesKeepTheirEdges) {
  const auto kind = [&](const Outline& outline) { return triangulator_.triangulate(on_floor(outline)).kind; };
  const Outline bow_tie{{0, 0}, {10, 10}, {10, 0}, {0, 10}};
  const Outline uneven{{0, 0}, {10, 10}, {10, 0}, {0, 4}};
  Outline pentagram;
  for (int i = 0; i < 5; ++i)
    pentagram.push_back(
        {std::llround(1000 * std::cos(kTurn * 2 * i / 5)), std::llround(1000 * std::sin(kTurn * 2 * i / 5))});
  Outline twice = pentagram;
  twice.insert(twice.end(), pentagram.begin(), pentagram.end());
  for (const Outline& outline : {bow_tie, uneven, pentagram, twice}) {
    EXPECT_EQ(kind(outline), PolygonKind::kCrossing);
    expect_edges_all_ways(on_floor(outline));
  }
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Outline outline;
    const std::int64_t reach = seed % 3 == 0 ? 3 : 1000;
    for (std::int64_t i = between(random, 4, 40); i > 0; --i)
      outline.push_back({between(random, 0, reach), between(random, 0, reach)});
    expect_edges_all_ways(in_plane(random, outline, reach));
    Corners anywhere;
    for (const Flat& p : outline)
      anywhere.push_back({static_cast<std::int32_t>(p[0]), static_cast<std::int32_t>(p[1]),
                          static_cast<std::int32_t>(between(random, 0, reach))});
    expect_edges_all_ways(anywhere);
    for (Point& p : anywhere)
      p = {p.x > reach / 2 ? kRootSide : 0, p.y > reach / 2 ? kRootSide : 0, p.z > reach / 2 ? kRootSide : 0};
    expect_edges_all_ways(anywhere);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(covered_elsewhere_, 0);
}

TEST_F(Polygon, AreWarpedFromATwentiethOfTheirSide) {
  const auto kind = [&](std::int32_t side, std::int32_t height) {
    const Corners corners{
        {0, 0, 0}, {side, 0, height}, {side, side, 0}, {0, side, height}};  // half of it off the plane
    return expect_covered(corners, true);
  };
  for (const std::int32_t side : {1000, 4000, 1000000, kRootSide}) {
    EXPECT_EQ(kind(side, side / 10), PolygonKind::kConvex);
    EXPECT_EQ(kind(side, side / 10 + side / 100), PolygonKind::kWarped);
  }
  for (const std::int32_t side : {8, 16, 100, 300}) EXPECT_EQ(kind(side, 32), PolygonKind::kConvex);
  EXPECT_EQ(kind(300, 40), PolygonKind::kWarped);
  // A chevron, a corner of which is lifted.
  Corners chevron{{0, 0, 0}, {4000, 2000, 0}, {8000, 0, 0}, {4000, 8000, 0}};
  EXPECT_EQ(expect_covered(chevron, true), PolygonKind::kConcave);
  chevron[1].z = 3000;
  EXPECT_EQ(expect_covered(chevron, true), PolygonKind::kWarped);
  Corners hexagon = on_floor({{0, 0}, {2000, 0}, {3000, 1500}, {2000, 3000}, {0, 3000}, {500, 1500}});
  EXPECT_EQ(expect_covered(hexagon, true), PolygonKind::kConcave);
  for (std::size_t i = 0; i < 6; i += 2) hexagon[i].z += 1000;
  EXPECT_EQ(expect_covered(hexagon, true), PolygonKind::kWarped);
}

TEST_F(Polygon, RoundingIsNotWarping) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Outline outline = star(random, static_cast<int>(between(random, 4, 12)), 0.5,
                                 static_cast<double>(between(random, 30, 2000)));
    EXPECT_NE(triangulator_.triangulate(in_rounded_plane(random, outline)).kind, PolygonKind::kWarped);
  }
}

TEST_F(Polygon, TheSameCornersGiveTheSameTriangles) {
  PolygonTriangulator other;  // has triangulated other polygons before
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Corners corners = in_plane(random, untangled(random, 12, 100), 100);
    const auto first = other.triangulate(corners).triangles;
    const auto second = triangulator_.triangulate(corners).triangles;
    EXPECT_TRUE(std::equal(first.begin(), first.end(), second.begin(), second.end()));
  }
}

TEST_F(Polygon, LargeOnesEnd) {
  Random random(1);
  const double radius = kRootSide * 0.49;
  for (const Outline& outline :
       {star(random, 100000, 0.2, radius), gear(100000, radius), spiral(100000, 50, radius),
        spiral(100000, 1000, radius), comb(random, 25000, 4000, 200000000), glued(random, 50000, 1000, true),
        glued(random, 50000, 1000, false)}) {
    EXPECT_EQ(expect_covered(on_floor(outline), false), PolygonKind::kConcave);
  }
}

TEST_F(Polygon, LargeOnesThatAreCloseTogetherEnd) {
  // All of it but one corner within a millionth.
  Random random(1);
  Outline outline = star(random, 100000, 0.5, 500);
  outline[0] = {kRootSide / 3, 0};
  const Corners corners = on_floor(outline);
  EXPECT_TRUE(keeps_edges(corners, triangulator_.triangulate(corners).triangles));
}

TEST_F(Polygon, LargeOnesThatCrossThemselvesEnd) {
  for (const int count : {10000, 30000}) {
    Random random(1);
    Outline outline;
    for (int i = 0; i < count; ++i)
      outline.push_back({between(random, 0, 1000000), between(random, 0, 1000000)});
    const Corners corners = on_floor(outline);
    const auto [kind, triangles] = triangulator_.triangulate(corners);
    EXPECT_EQ(kind, PolygonKind::kCrossing);
    EXPECT_TRUE(keeps_edges(corners, triangles));
  }
}

}  // namespace
}  // namespace colossus::geometry
