// Extended quadrics (Garland and Heckbert 1998, "Simplifying surfaces with color and texture using quadric
// error metrics"): weighted sums of squared distances to the planes of triangles in the space of positions
// and colours together. Departures: a triangle weighs as much as its area in space, so that a sudden change
// of colour counts by its height and not by its steepness too; and only values are asked for, no minimum.
#pragma once

#include <array>
#include <cstddef>

#include "geometry/vector.hpp"

namespace colossus::geometry {

// x, y, z, and a colour in the same unit.
struct AttributePoint {
  std::array<double, 6> at{};

  AttributePoint() = default;
  AttributePoint(const Vec3& position, const Vec3& color)
      : at{position.x, position.y, position.z, color.x, color.y, color.z} {}

  friend AttributePoint operator-(const AttributePoint& p, const AttributePoint& q) {
    AttributePoint difference;
    for (std::size_t i = 0; i < 6; ++i) difference.at[i] = p.at[i] - q.at[i];
    return difference;
  }
  friend AttributePoint operator*(double s, const AttributePoint& p) {
    AttributePoint product;
    for (std::size_t i = 0; i < 6; ++i) product.at[i] = s * p.at[i];
    return product;
  }
};

inline double dot(const AttributePoint& p, const AttributePoint& q) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 6; ++i) sum += p.at[i] * q.at[i];
  return sum;
}

// x^T A x + 2 b^T x + c with symmetric A. All sums are made in one fixed order.
class AttributeQuadric {
 public:
  // Adds the squared distance to the plane that p, q and r span. Nothing where they are collinear.
  void add_triangle(const AttributePoint& p, const AttributePoint& q, const AttributePoint& r,
                    double weight) {
    const double first_length = std::sqrt(dot(q - p, q - p));
    if (!(first_length > 0.0)) return;
    const AttributePoint e1 = (1.0 / first_length) * (q - p);
    const AttributePoint across = (r - p) - dot(r - p, e1) * e1;
    const double second_length = std::sqrt(dot(across, across));
    if (!(second_length > 0.0)) return;
    const AttributePoint e2 = (1.0 / second_length) * across;
    std::size_t k = 0;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = i; j < 6; ++j)
        a_[k++] += weight * ((i == j ? 1.0 : 0.0) - e1.at[i] * e1.at[j] - e2.at[i] * e2.at[j]);
    // The shortest way from the plane to the origin: its square loses less than p^2 - (p e1)^2 - (p e2)^2
    // would.
    const AttributePoint way = dot(p, e1) * e1 - (p - dot(p, e2) * e2);
    for (std::size_t i = 0; i < 6; ++i) b_[i] += weight * way.at[i];
    c_ += weight * dot(way, way);
  }

  // Adds the plane in space through `point` with unit normal `n`, whatever the colour.
  void add_plane(const Vec3& n, const Vec3& point, double weight) {
    const double d = -dot(n, point);
    const std::array<double, 3> normal{n.x, n.y, n.z};
    for (std::size_t i = 0, row = 0; i < 3; row += 6 - i, ++i) {
      for (std::size_t j = i; j < 3; ++j) a_[row + j - i] += weight * normal[i] * normal[j];
      b_[i] += weight * normal[i] * d;
    }
    c_ += weight * d * d;
  }

  void add(const AttributeQuadric& q) {
    for (std::size_t k = 0; k < a_.size(); ++k) a_[k] += q.a_[k];
    for (std::size_t i = 0; i < b_.size(); ++i) b_[i] += q.b_[i];
    c_ += q.c_;
  }

  // Never negative: rounding below zero counts as zero.
  double at(const AttributePoint& p) const {
    double value = c_;
    std::size_t k = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      const double diagonal = a_[k++] * p.at[i];
      double rest = b_[i];
      for (std::size_t j = i + 1; j < 6; ++j) rest += a_[k++] * p.at[j];
      value += p.at[i] * (diagonal + 2.0 * rest);
    }
    return value > 0.0 ? value : 0.0;
  }

 private:
  std::array<double, 21> a_{};  // the upper triangle, row by row
  std::array<double, 6> b_{};
  double c_ = 0.0;
};

}  // namespace colossus::geometry
