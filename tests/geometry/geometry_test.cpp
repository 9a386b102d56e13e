#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/lattice.hpp"
#include "geometry/octahedral.hpp"
#include "geometry/plane.hpp"

namespace colossus::geometry {
namespace {

Point random_point(std::mt19937_64& random) {
  return {static_cast<std::int32_t>(random() % kRootSide), static_cast<std::int32_t>(random() % kRootSide),
          static_cast<std::int32_t>(random() % kRootSide)};
}

TEST(Lattice, HoldsItsBoundsStrictlyInsideAndLosesLittle) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double scale : {1e-9, 1e-3, 1.0, 12.345, 1e7})
    for (const double shift : {0.0, -3.0, 5e5, 4.4e6}) {
      Bounds bounds;
      std::vector<std::array<double, 3>> points;
      for (int i = 0; i < 100; ++i) {
        points.push_back(
            {shift + scale * unit(random), 2 * shift + scale * unit(random), scale * unit(random)});
        bounds.add(points.back());
      }
      const Lattice lattice = Lattice::fit(bounds);
      EXPECT_EQ(std::exp2(std::round(std::log2(lattice.step))), lattice.step);
      for (const auto& p : points) {
        const Point q = lattice.input_vertex(p);
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_GT(q[axis], 0);
          ASSERT_LT(q[axis], kRootSide);
          ASSERT_EQ(q[axis] % kInputSpacing, kInputResidue[static_cast<std::size_t>(axis)]);
        }
        const auto back = lattice.world({double(q.x), double(q.y), double(q.z)});
        const double distance = std::sqrt(std::pow(back[0] - p[0], 2) + std::pow(back[1] - p[1], 2) +
                                          std::pow(back[2] - p[2], 2));
        ASSERT_LE(distance, lattice.input_error() * 1.001 + 1e-15 * std::abs(shift));
      }
    }
}

TEST(Lattice, KeepsMillimetresAtUtmCoordinates) {
  Bounds bounds;
  bounds.add({500000.0, 5400000.0, 100.0});
  bounds.add({500010.0, 5400010.0, 110.0});
  const Lattice lattice = Lattice::fit(bounds);
  EXPECT_LT(lattice.input_error(), 1e-6);
  EXPECT_NE(lattice.input_vertex({500001.001, 5400001.0, 105.0}),
            lattice.input_vertex({500001.002, 5400001.0, 105.0}));
}

TEST(Lattice, TakesASinglePoint) {
  Bounds bounds;
  bounds.add({0.0, 0.0, 0.0});
  const Lattice lattice = Lattice::fit(bounds);
  EXPECT_GT(lattice.input_vertex({0.0, 0.0, 0.0}).x, 0);
}

// The cut point lies on the cutting plane, on every plane the edge lies on, does not depend on the direction
// of the edge, and stays on the right side of every other plane.
TEST(Plane, CutPointsAreExact) {
  std::mt19937_64 random(5);
  const std::array<std::array<std::int8_t, 3>, 9> normals{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, -1, 0}, {0, 1, 1}, {0, 1, -1}, {1, 0, 1}, {1, 0, -1}}};
  int cuts = 0;
  while (cuts < 20000) {
    const Point p = random_point(random);
    const Point q = random_point(random);
    Plane plane{normals[random() % 9], static_cast<std::int64_t>(random() % kRootSide / 8 * 8)};
    if (plane.side(p) == 0 || plane.side(q) == 0 || (plane.side(p) > 0) == (plane.side(q) > 0)) continue;
    ++cuts;
    const Point cut = cut_edge(p, q, plane.side(p), plane.side(q));
    ASSERT_EQ(plane.side(cut), 0);
    ASSERT_EQ(cut, cut_edge(q, p, plane.side(q), plane.side(p)));
    // A second edge within the plane, cut by another plane, stays in the first.
    const Point r = random_point(random);
    if (plane.side(r) == 0 || (plane.side(p) > 0) == (plane.side(r) > 0)) continue;
    const Point second = cut_edge(p, r, plane.side(p), plane.side(r));
    const Plane other{normals[random() % 9], static_cast<std::int64_t>(random() % kRootSide / 8 * 8)};
    const std::int64_t a = other.side(cut);
    const std::int64_t b = other.side(second);
    if (a == 0 || b == 0 || (a > 0) == (b > 0)) continue;
    const Point both = cut_edge(cut, second, a, b);
    ASSERT_EQ(plane.side(both), 0);
    ASSERT_EQ(other.side(both), 0);
  }
}

TEST(Octahedral, ErrorIsBelowOneDegree) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> gauss;
  double worst = 1.0;
  for (int i = 0; i < 20000; ++i) {
    const Normal16 n = to_normal16(gauss(random), gauss(random), gauss(random));
    const auto back = decode_octahedral(encode_octahedral(n));
    const double length = std::sqrt(double(n[0]) * n[0] + double(n[1]) * n[1] + double(n[2]) * n[2]);
    worst = std::min(worst, (back[0] * n[0] + back[1] * n[1] + back[2] * n[2]) / length);
  }
  EXPECT_GT(worst, std::cos(1.0 * 3.14159265 / 180.0));
  EXPECT_EQ(to_normal16(0, 0, 0), (Normal16{0, 0, 32767}));
}

}  // namespace
}  // namespace colossus::geometry
