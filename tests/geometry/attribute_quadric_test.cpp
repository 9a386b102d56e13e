#include "geometry/attribute_quadric.hpp"

#include <gtest/gtest.h>

#include <random>

#include "geometry/quadric.hpp"

namespace colossus::geometry {
namespace {

class AttributeQuadricTest : public testing::TestWithParam<std::uint64_t> {
 protected:
  double number() { return unit_(random_); }
  Vec3 vector() { return {number(), number(), number()}; }
  AttributePoint place() { return {vector(), vector()}; }

  std::mt19937_64 random_{GetParam()};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

INSTANTIATE_TEST_SUITE_P(Seeds, AttributeQuadricTest, testing::Range<std::uint64_t>(0, 20));

TEST_P(AttributeQuadricTest, IsZeroOnThePlaneOfItsTriangle) {
  const AttributePoint p = place(), q = place(), r = place();
  AttributeQuadric quadric;
  quadric.add_triangle(p, q, r, 7.0);
  for (int i = 0; i < 20; ++i) EXPECT_LT(quadric.at(p - number() * (q - p) - number() * (r - p)), 1e-12);
}

TEST_P(AttributeQuadricTest, GrowsWithTheSquaredDistance) {
  const AttributePoint p = place(), q = place(), r = place();
  AttributeQuadric quadric;
  quadric.add_triangle(p, q, r, 3.0);
  // Perpendicular to both sides: what is left of any direction without its part in the plane.
  const AttributePoint u = q - p;
  const AttributePoint v = (r - p) - dot(r - p, u) / dot(u, u) * u;
  AttributePoint away = place();
  away = away - dot(away, u) / dot(u, u) * u;
  away = away - dot(away, v) / dot(v, v) * v;
  for (const double factor : {0.5, 1.0, -4.0})
    EXPECT_NEAR(quadric.at(p - number() * u - factor * away), 3.0 * factor * factor * dot(away, away), 1e-10);
}

TEST_P(AttributeQuadricTest, IsThePlaneInSpaceWhereColorsAreEqual) {
  const Vec3 a = vector(), b = vector(), c = vector(), color = vector(), n = vector(), point = vector();
  const Vec3 normal = (1.0 / length(cross(b - a, c - a))) * cross(b - a, c - a);
  const Vec3 unit = (1.0 / length(n)) * n;
  Quadric expected;
  expected.add_plane(normal, a, 2.0);
  expected.add_plane(unit, point, 5.0);
  AttributeQuadric triangle;
  triangle.add_triangle({a, color}, {b, color}, {c, color}, 2.0);
  AttributeQuadric found;
  found.add_plane(unit, point, 5.0);
  const Vec3 p = vector();
  // A plane in space does not see colours, a triangle does.
  EXPECT_EQ(found.at({p, color}), found.at({p, vector()}));
  const Vec3 change = vector();
  EXPECT_NEAR(triangle.at({a, color + change}), 2.0 * squared_length(change), 1e-10);
  found.add(triangle);
  EXPECT_NEAR(found.at({p, color}), expected.at(p), 1e-10);
}

TEST(AttributeQuadric, IgnoresCollinearCorners) {
  const AttributePoint p({0, 0, 0}, {1, 2, 3}), q({4, 0, 0}, {1, 2, 3}), r({8, 0, 0}, {1, 2, 3});
  AttributeQuadric quadric;
  quadric.add_triangle(p, p, q, 1.0);
  quadric.add_triangle(p, q, q, 1.0);
  quadric.add_triangle(p, q, r, 1.0);
  EXPECT_EQ(quadric.at({{5, 6, 7}, {8, 9, 10}}), 0.0);
  // A change of colour alone spans a plane with it.
  quadric.add_triangle(p, q, {{8, 0, 0}, {1, 2, 5}}, 1.0);
  EXPECT_NEAR(quadric.at({{3, 0, 2}, {1, 2, 9}}), 4.0, 1e-12);
}

}  // namespace
}  // namespace colossus::geometry
