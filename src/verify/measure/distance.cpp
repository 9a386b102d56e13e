#include "verify/measure/distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "reader/access/parallel.hpp"

namespace colossus::verify::measure {
namespace {

constexpr std::size_t kLeafTriangles = 6;  // at most, in a leaf of the tree
constexpr int kParallelDepth = 3;          // levels of the tree whose halves are built side by side
constexpr std::size_t kDistanceRun =
    1024;  // samples of one thread at a time; sums are added in the order of runs

WorldPoint operator-(const WorldPoint& a, const WorldPoint& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const WorldPoint& a, const WorldPoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

WorldPoint cross(const WorldPoint& a, const WorldPoint& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Squared distance from the origin to the segment.
double segment_squared(const WorldPoint& a, const WorldPoint& b) {
  const WorldPoint u = b - a;
  const double length = dot(u, u);
  const double t = length > 0.0 ? std::clamp(-dot(a, u) / length, 0.0, 1.0) : 0.0;
  const WorldPoint q{a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2]};
  return dot(q, q);
}

// Squared distance from the origin to the triangle: to its plane where the foot lies inside, else to its
// sides.
double triangle_squared(const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const WorldPoint n = cross(b - a, c - a);
  const double nn = dot(n, n);
  if (nn > 0.0 && dot(cross(a, b), n) >= 0.0 && dot(cross(b, c), n) >= 0.0 && dot(cross(c, a), n) >= 0.0) {
    const double height = dot(a, n);
    return height * height / nn;
  }
  return std::min({segment_squared(a, b), segment_squared(b, c), segment_squared(c, a)});
}

double box_squared(const WorldPoint& p, const WorldPoint& low, const WorldPoint& high) {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double outside = std::max({low[axis] - p[axis], 0.0, p[axis] - high[axis]});
    sum += outside * outside;
  }
  return sum;
}

// Squared distance from the origin to the triangle's box, which is no more than to the triangle.
double triangle_box_squared(const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = std::min(std::min(a[axis], b[axis]), c[axis]);
    const double high = std::max(std::max(a[axis], b[axis]), c[axis]);
    const double outside = std::max(std::max(low, 0.0), -high);
    sum += outside * outside;
  }
  return sum;
}

// A pseudo-random number in [0, 1) for a seed and a counter.
double uniform(std::uint64_t seed, std::uint64_t counter) {
  return static_cast<double>(core::mix64(core::mix64(seed) + counter * 0x9e3779b97f4a7c15ULL) >> 11) *
         0x1p-53;
}

// Points spread evenly by area: sample k lies in the k-th of `count` equal parts of the cumulated area.
std::vector<WorldPoint> sample_area(const Surface& surface, std::size_t count, std::uint64_t seed) {
  std::vector<double> cumulated;
  cumulated.reserve(surface.triangles.size());
  double total = 0.0;
  for (const mesh::Triangle& t : surface.triangles) {
    const WorldPoint n =
        cross(surface.points[t[1]] - surface.points[t[0]], surface.points[t[2]] - surface.points[t[0]]);
    cumulated.push_back(total += std::sqrt(dot(n, n)) / 2.0);
  }
  std::vector<WorldPoint> samples;
  if (!(total > 0.0)) return samples;
  samples.reserve(count);
  std::size_t triangle = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double target =
        (static_cast<double>(k) + uniform(seed, 3 * k)) / static_cast<double>(count) * total;
    while (triangle + 1 < cumulated.size() && cumulated[triangle] <= target) ++triangle;
    const mesh::Triangle& t = surface.triangles[triangle];
    const double r = std::sqrt(uniform(seed, 3 * k + 1));
    const double s = uniform(seed, 3 * k + 2);
    WorldPoint p{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = (1.0 - r) * surface.points[t[0]][axis] + r * (1.0 - s) * surface.points[t[1]][axis] +
                r * s * surface.points[t[2]][axis];
    samples.push_back(p);
  }
  return samples;
}

std::vector<WorldPoint> sample_vertices(const Surface& surface, std::size_t count) {
  const std::size_t corners = surface.triangles.size() * 3;
  const std::size_t stride =
      std::max<std::size_t>(1, (corners + count - 1) / std::max<std::size_t>(1, count));
  std::vector<WorldPoint> samples;
  for (std::size_t i = 0; i < corners && samples.size() < count; i += stride)
    samples.push_back(surface.points[surface.triangles[i / 3][i % 3]]);
  return samples;
}

struct Sums {
  double squares = 0.0;
  double max = 0.0;
};

Sums measure(const std::vector<WorldPoint>& samples, const SurfaceIndex& index) {
  std::vector<Sums> runs((samples.size() + kDistanceRun - 1) / kDistanceRun);
  reader::access::parallel_for(runs.size(), [&](std::size_t run) {
    std::uint32_t near = 0;
    const std::size_t end = std::min(samples.size(), (run + 1) * kDistanceRun);
    for (std::size_t i = run * kDistanceRun; i < end; ++i) {
      const auto found = index.nearest(samples[i], near);
      near = found.triangle;
      runs[run].squares += found.distance * found.distance;
      runs[run].max = std::max(runs[run].max, found.distance);
    }
  });
  Sums sums;
  for (const Sums& run : runs) {
    sums.squares += run.squares;
    sums.max = std::max(sums.max, run.max);
  }
  return sums;
}

OneSidedDistance one_sided(const Surface& from, const SurfaceIndex& to, std::size_t samples,
                           std::uint64_t seed) {
  const std::vector<WorldPoint> spread = sample_area(from, samples, seed);
  const Sums by_area = measure(spread, to);
  const Sums at_vertices = measure(sample_vertices(from, samples / 2), to);
  OneSidedDistance result;
  result.rms = spread.empty() ? 0.0 : std::sqrt(by_area.squares / static_cast<double>(spread.size()));
  result.max = std::max(by_area.max, at_vertices.max);
  return result;
}

}  // namespace

double triangle_distance(const WorldPoint& p, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  return std::sqrt(triangle_squared(a - p, b - p, c - p));
}

SurfaceIndex::SurfaceIndex(const Surface& surface) : surface_(surface), order_(surface.triangles.size()) {
  COLOSSUS_CHECK(!order_.empty() && order_.size() < ~std::uint32_t{0});
  std::iota(order_.begin(), order_.end(), 0U);
  while ((order_.size() >> depth_) > kLeafTriangles) ++depth_;
  boxes_.resize((std::size_t{2} << depth_) - 1);
  build(0, 0, order_.size(), 0);
}

SurfaceIndex::Box SurfaceIndex::box_of(std::size_t begin, std::size_t end) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (std::size_t i = begin; i < end; ++i)
    for (const std::uint32_t v : surface_.triangles[order_[i]])
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(box.low[axis], surface_.points[v][axis]);
        box.high[axis] = std::max(box.high[axis], surface_.points[v][axis]);
      }
  return box;
}

void SurfaceIndex::build(std::size_t node, std::size_t begin, std::size_t end, int depth) {
  const Box box = box_of(begin, end);
  boxes_[node] = box;
  if (depth == depth_) return;
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (box.high[k] - box.low[k] > box.high[axis] - box.low[axis]) axis = k;
  const auto middle = [&](std::uint32_t t) {
    const mesh::Triangle& v = surface_.triangles[t];
    return surface_.points[v[0]][axis] + surface_.points[v[1]][axis] + surface_.points[v[2]][axis];
  };
  const std::size_t half = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(half), at(end), [&](std::uint32_t a, std::uint32_t b) {
    const double middle_a = middle(a);
    const double middle_b = middle(b);
    return middle_a != middle_b ? middle_a < middle_b : a < b;
  });
  const auto child = [&](std::size_t i) {
    build(2 * node + 1 + i, i == 0 ? begin : half, i == 0 ? half : end, depth + 1);
  };
  // Two threads at each of the first levels; what the tree is does not depend on them.
  if (depth < kParallelDepth && end - begin > kDistanceRun) {
    reader::access::parallel_for(2, child);
  } else {
    child(0);
    child(1);
  }
}

SurfaceIndex::Nearest SurfaceIndex::nearest(const WorldPoint& p, std::uint32_t near, double enough) const {
  // Some value that is not below `least` where the distance is not.
  const auto squared_to = [&](std::uint32_t t, double least) {
    const mesh::Triangle& v = surface_.triangles[t];
    const WorldPoint a = surface_.points[v[0]] - p;
    const WorldPoint b = surface_.points[v[1]] - p;
    const WorldPoint c = surface_.points[v[2]] - p;
    const double to_box = triangle_box_squared(a, b, c);
    return to_box < least ? triangle_squared(a, b, c) : to_box;
  };
  struct Pending {
    std::size_t node;
    std::size_t begin;
    std::size_t end;
    int depth;
    double squared;
  };
  double best = squared_to(near, std::numeric_limits<double>::infinity());
  std::uint32_t best_triangle = near;
  // Depth first, so at most one pending sibling per level; 40 levels are more than 2^32 triangles need.
  std::array<Pending, 48> stack;
  std::size_t top = 0;
  stack[top++] = {0, 0, order_.size(), 0, box_squared(p, boxes_[0].low, boxes_[0].high)};
  while (top > 0 && best > enough * enough) {
    const Pending next = stack[--top];
    if (!(next.squared < best)) continue;
    if (next.depth == depth_) {
      for (std::size_t i = next.begin; i < next.end; ++i)
        if (const double squared = squared_to(order_[i], best); squared < best) {
          best = squared;
          best_triangle = order_[i];
        }
      continue;
    }
    const std::size_t half = next.begin + (next.end - next.begin) / 2;
    const std::size_t left = 2 * next.node + 1;
    Pending first{left, next.begin, half, next.depth + 1,
                  box_squared(p, boxes_[left].low, boxes_[left].high)};
    Pending second{left + 1, half, next.end, next.depth + 1,
                   box_squared(p, boxes_[left + 1].low, boxes_[left + 1].high)};
    if (first.squared < second.squared) std::swap(first, second);
    stack[top++] = first;
    stack[top++] = second;
  }
  return {std::sqrt(best), best_triangle};
}

std::vector<WorldPoint> sample_surface(const Surface& surface, std::size_t count, std::uint64_t seed) {
  std::vector<WorldPoint> samples = sample_vertices(surface, count / 2);
  const std::vector<WorldPoint> spread = sample_area(surface, count - samples.size(), seed);
  samples.insert(samples.end(), spread.begin(), spread.end());
  return samples;
}

SurfaceDistances surface_distances(const Surface& a, const Surface& b, std::size_t samples,
                                   std::uint64_t seed) {
  SurfaceDistances result;
  result.a_to_b = one_sided(a, SurfaceIndex(b), samples, seed);
  result.b_to_a = one_sided(b, SurfaceIndex(a), samples, seed);
  return result;
}

}  // namespace colossus::verify::measure
