#include "geometry/plane.hpp"

#include <cstdlib>

#include "core/error.hpp"

namespace colossus::geometry {
namespace {

// base + numerator / denominator, rounded half to even; denominator > 0.
std::int32_t rounded(std::int64_t base, std::int64_t numerator, std::int64_t denominator) {
  std::int64_t quotient = numerator / denominator;
  std::int64_t remainder = numerator % denominator;
  if (remainder < 0) {
    remainder += denominator;
    --quotient;
  }
  std::int64_t value = base + quotient;
  const std::int64_t twice = 2 * remainder;
  // The parity is that of the absolute coordinate, not of the offset from `base`.
  if (twice > denominator || (twice == denominator && (value & 1) != 0)) ++value;
  return static_cast<std::int32_t>(value);
}

}  // namespace

Plane plane_through(const Point& a, const Point& b, const Point& c, const Point& above) {
  const std::array<std::int64_t, 3> u{std::int64_t{b.x} - a.x, std::int64_t{b.y} - a.y,
                                      std::int64_t{b.z} - a.z};
  const std::array<std::int64_t, 3> v{std::int64_t{c.x} - a.x, std::int64_t{c.y} - a.y,
                                      std::int64_t{c.z} - a.z};
  const std::array<std::int64_t, 3> n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                      u[0] * v[1] - u[1] * v[0]};
  const std::int64_t scale = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
  COLOSSUS_CHECK(scale > 0);
  Plane plane;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    COLOSSUS_CHECK(n[axis] == 0 || std::abs(n[axis]) == scale, "not a plane of the hierarchy");
    plane.normal[axis] = static_cast<std::int8_t>(n[axis] / scale);
  }
  plane.offset = plane.side(a);
  const std::int64_t side = plane.side(above);
  COLOSSUS_CHECK(side != 0);
  if (side < 0) {
    for (auto& component : plane.normal) component = static_cast<std::int8_t>(-component);
    plane.offset = -plane.offset;
  }
  return plane;
}

Point cut_edge(const Point& p, const Point& q, std::int64_t side_p, std::int64_t side_q) {
  const std::int64_t numerator = std::abs(side_p);
  const std::int64_t denominator = numerator + std::abs(side_q);
  return {rounded(p.x, (std::int64_t{q.x} - p.x) * numerator, denominator),
          rounded(p.y, (std::int64_t{q.y} - p.y) * numerator, denominator),
          rounded(p.z, (std::int64_t{q.z} - p.z) * numerator, denominator)};
}

}  // namespace colossus::geometry
