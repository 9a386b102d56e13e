#include "codec/predict/basis.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace colossus::codec::predict {
namespace {

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int32_t dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Matrix transposed(const Matrix& m) {
  return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}

struct Candidate {
  Vector factors;
  Vector direction;
  std::int32_t length;  // squared
};

// One of each two opposite ones, shortest first.
std::vector<Candidate> candidates_of(const coded::Frame& frame) {
  std::vector<Candidate> candidates;
  for (std::int32_t number = 14; number < 27; ++number) {
    Candidate c{{number % 3 - 1, number / 3 % 3 - 1, number / 9 - 1}, {}, 0};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t row = 0; row < 3; ++row) c.direction[axis] += c.factors[row] * frame[row][axis];
    c.length = dot(c.direction, c.direction);
    candidates.push_back(c);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.length < b.length; });
  return candidates;
}

}  // namespace

Basis basis_of(const coded::Frame& frame) {
  const std::vector<Candidate> candidates = candidates_of(frame);
  const Candidate& first = candidates[0];
  const auto second = std::find_if(candidates.begin() + 1, candidates.end(), [&](const Candidate& c) {
    const Vector n = cross(first.factors, c.factors);
    return std::gcd(std::gcd(n[0], n[1]), n[2]) == 1;
  });
  const Vector normal = cross(first.factors, second->factors);
  const auto third = std::find_if(second + 1, candidates.end(),
                                  [&](const Candidate& c) { return std::abs(dot(normal, c.factors)) == 1; });
  // An entry of the normal is 1 or -1, so one of the axes will do, but it may be shorter than the second.
  const Candidate& last = third != candidates.end()
                              ? *third
                              : *std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
                                  return std::abs(dot(normal, c.factors)) == 1;
                                });
  const std::int32_t determinant = dot(normal, last.factors);
  Basis basis;
  basis.to_weights = transposed({first.factors, second->factors, last.factors});
  basis.from_weights = {cross(second->factors, last.factors), cross(last.factors, first.factors), normal};
  for (Vector& row : basis.from_weights)
    for (auto& entry : row) entry *= determinant;
  const Matrix directions{first.direction, second->direction, last.direction};
  basis.to_world = directions;
  Matrix products{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) products[i][j] = dot(directions[i], directions[j]);
  basis.metric = {cross(products[1], products[2]), cross(products[2], products[0]),
                  cross(products[0], products[1])};
  return basis;
}

}  // namespace colossus::codec::predict
