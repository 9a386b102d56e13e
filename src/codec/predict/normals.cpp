#include "codec/predict/normals.hpp"

#include <algorithm>
#include <bit>

namespace colossus::codec::predict {
namespace {

// Differences of coordinates keep so many bits: cross products, summed over a million triangles, fit.
constexpr int kEdgeBits = 18;
// A component of a sum keeps so many bits when it is projected.
constexpr int kSumBits = 22;

// Sums of face normals at each vertex, by area.
std::vector<LongVector> face_sums(const CodedNode& node, const CodedPart& part) {
  const int shift = std::max(0, node.position_bits - kEdgeBits);
  std::vector<Vector> points(part.positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Coordinates& w = part.positions[v];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t sum = 0;
      for (std::size_t row = 0; row < 3; ++row)
        sum += (w[row] >> shift) * static_cast<std::uint32_t>(int{part.frame[row][axis]});
      points[v][axis] = static_cast<std::int32_t>(sum);
    }
  }
  std::vector<LongVector> sums(points.size());
  for (const mesh::Triangle& t : part.triangles) {
    const Vector& p = points[t[0]];
    LongVector a{};
    LongVector b{};
    for (std::size_t i = 0; i < 3; ++i) {
      a[i] = points[t[1]][i] - p[i];
      b[i] = points[t[2]][i] - p[i];
    }
    const LongVector n{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    for (const std::uint32_t v : t)
      for (std::size_t i = 0; i < 3; ++i) sums[v][i] += n[i];
  }
  return sums;
}

// Adds to `weight` times each sum those of the neighbours, once per triangle.
std::vector<LongVector> smoothed(const std::vector<LongVector>& sums, const CodedPart& part,
                                 std::int64_t weight) {
  std::vector<LongVector> result(sums.size());
  for (std::size_t v = 0; v < sums.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i) result[v][i] = weight * sums[v][i];
  for (const mesh::Triangle& t : part.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t all = sums[t[0]][i] + sums[t[1]][i] + sums[t[2]][i];
      for (const std::uint32_t v : t) result[v][i] += all - sums[v][i];
    }
  return result;
}

// A predicted normal in the octahedron's square. Around its lower pole the square is folded over, so that a
// prediction near its border has neighbours on all sides.
struct Projection {
  std::array<std::int32_t, 2> cell{128, 128};  // the nearest, 0 to 255
  std::array<bool, 2> is_below{};              // whether the prediction is below the cell's middle
  bool is_folded = false;
};

Projection project(LongVector n) {
  Projection projection;
  std::uint64_t size = 0;
  for (const std::int64_t entry : n) size |= static_cast<std::uint64_t>(std::abs(entry));
  if (size == 0) return projection;
  const int excess = static_cast<int>(std::bit_width(size)) - kSumBits;
  if (excess > 0)
    for (auto& entry : n) entry >>= excess;
  const auto sum = static_cast<std::uint32_t>(std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]));
  projection.is_folded = n[2] < 0;
  // 255 * (n / sum + 1) / 2 in fixed point, with one division.
  constexpr int kPoint = 30;
  const std::uint64_t scale = (std::uint64_t{255} << (kPoint - 1)) / sum;
  for (std::size_t k = 0; k < 2; ++k) {
    const std::uint64_t value = static_cast<std::uint64_t>(n[k] + sum) * scale;
    const std::uint64_t cell = (value + (std::uint64_t{1} << (kPoint - 1))) >> kPoint;
    projection.cell[k] = static_cast<std::int32_t>(cell);
    projection.is_below[k] = value < cell << kPoint;
  }
  return projection;
}

// Its own inverse.
std::array<std::int32_t, 2> folded(const std::array<std::int32_t, 2>& cell) {
  const std::int32_t x = 2 * cell[0] - 255;
  const std::int32_t y = 2 * cell[1] - 255;
  const std::int32_t fx = x < 0 ? std::abs(y) - 256 : 256 - std::abs(y);
  const std::int32_t fy = y < 0 ? std::abs(x) - 256 : 256 - std::abs(x);
  return {(fx + 255) / 2, (fy + 255) / 2};
}

constexpr std::int32_t wrapped_byte(std::int32_t value) { return static_cast<std::int8_t>(value & 255); }

std::uint32_t second_context(const VertexLinks& links, std::uint32_t first) {
  const auto size = std::min<std::uint32_t>(
      static_cast<std::uint32_t>(std::bit_width((first >> 1) + (first & 1U))), kNormalSizes - 1);
  return 2 + (links.is_border ? kNormalSizes : 0) + size;
}

class Predictor {
 public:
  Predictor(NormalMode mode, const std::vector<VertexLinks>& links, const CodedNode& node,
            const CodedPart& part)
      : links_(links), expects_misses_(mode != NormalMode::kSum), sums_(face_sums(node, part)) {
    if (mode == NormalMode::kSmoothed) sums_ = smoothed(sums_, part, 8);
    if (mode == NormalMode::kMoreSmoothed) sums_ = smoothed(sums_, part, 3);
    if (expects_misses_) misses_.resize(sums_.size());
  }

  Projection project_sum(std::uint32_t v) const { return project(sums_[v]); }

  // Half the mean of what the neighbours' projections missed their normals by.
  std::array<std::int32_t, 2> expected_miss(std::uint32_t v) const {
    std::array<std::int32_t, 2> expected{};
    const VertexLinks& links = links_[v];
    if (!expects_misses_ || links.neighbor_count == 0) return expected;
    for (std::size_t k = 0; k < 2; ++k) {
      std::int32_t sum = 0;
      for (const std::uint32_t neighbor : links.neighbors) sum += misses_[neighbor][k];
      expected[k] = sum / (2 * static_cast<std::int32_t>(kMostNeighbors));
    }
    return expected;
  }
  void set_miss(std::uint32_t v, const std::array<std::int32_t, 2>& miss) {
    if (expects_misses_) misses_[v] = {static_cast<std::int8_t>(miss[0]), static_cast<std::int8_t>(miss[1])};
  }

 private:
  const std::vector<VertexLinks>& links_;
  bool expects_misses_;
  std::vector<LongVector> sums_;
  std::vector<std::array<std::int8_t, 2>> misses_;
};

// Calls back with what is left of each normal, in order.
template <typename Take>
void for_each_residual(NormalMode mode, const std::vector<VertexLinks>& links, const CodedNode& node,
                       const CodedPart& part, Take take) {
  Predictor predictor(mode, links, node, part);
  for (std::uint32_t v = 0; v < part.normals.size(); ++v) {
    const Projection projection = predictor.project_sum(v);
    std::array<std::int32_t, 2> cell{part.normals[v][0], part.normals[v][1]};
    if (projection.is_folded) cell = folded(cell);
    const std::array<std::int32_t, 2> expected = predictor.expected_miss(v);
    std::array<std::int32_t, 2> miss{};
    std::array<std::uint32_t, 2> residual{};
    for (std::size_t k = 0; k < 2; ++k) {
      miss[k] = wrapped_byte(cell[k] - projection.cell[k]);
      const std::int32_t left = wrapped_byte(miss[k] - expected[k]);
      residual[k] = to_unsigned(projection.is_below[k] ? -left : left);
    }
    predictor.set_miss(v, miss);
    take(v, residual);
  }
}

}  // namespace

NormalMode choose_normal_mode(const CodedNode& node, const std::vector<std::vector<VertexLinks>>& links) {
  auto best = NormalMode::kSum;
  std::uint64_t least = ~std::uint64_t{0};
  for (std::uint8_t m = 0; m < kNormalModes; ++m) {
    std::uint64_t misses = 0;
    for (std::size_t i = 0; i < node.parts.size(); ++i)
      for_each_residual(static_cast<NormalMode>(m), links[i], node, node.parts[i],
                        [&](std::uint32_t, const std::array<std::uint32_t, 2>& residual) {
                          misses += residual[0] + residual[1];
                        });
    if (misses >= least) continue;
    least = misses;
    best = static_cast<NormalMode>(m);
  }
  return best;
}

void encode_normals(ValueEncoder& values, NormalMode mode, const std::vector<VertexLinks>& links,
                    const CodedNode& node, const CodedPart& part) {
  std::vector<std::array<std::uint32_t, 2>> residuals(part.normals.size());
  for_each_residual(mode, links, node, part,
                    [&](std::uint32_t v, const std::array<std::uint32_t, 2>& r) { residuals[v] = r; });
  for (std::size_t v = 0; v < residuals.size(); ++v) values.put(links[v].is_border ? 1 : 0, residuals[v][0]);
  values.end_batch();
  for (std::size_t v = 0; v < residuals.size(); ++v)
    values.put(second_context(links[v], residuals[v][0]), residuals[v][1]);
  values.end_batch();
}

void decode_normals(ValueDecoder& values, NormalMode mode, const std::vector<VertexLinks>& links,
                    const CodedNode& node, CodedPart& part) {
  const std::size_t count = part.normals.size();
  std::vector<std::uint32_t> first(count);
  std::vector<std::uint32_t> second(count);
  values.get_batch(first, [&](std::size_t v) { return links[v].is_border ? 1U : 0U; });
  values.get_batch(second, [&](std::size_t v) { return second_context(links[v], first[v]); });
  Predictor predictor(mode, links, node, part);
  for (std::uint32_t v = 0; v < count; ++v) {
    const Projection projection = predictor.project_sum(v);
    const std::array<std::int32_t, 2> expected = predictor.expected_miss(v);
    const std::array<std::int32_t, 2> residual{to_signed(first[v]), to_signed(second[v])};
    std::array<std::int32_t, 2> miss{};
    std::array<std::int32_t, 2> cell{};
    for (std::size_t k = 0; k < 2; ++k) {
      const std::int32_t left = wrapped_byte(residual[k]);
      miss[k] = wrapped_byte((projection.is_below[k] ? -left : left) + expected[k]);
      cell[k] = (projection.cell[k] + miss[k]) & 255;
    }
    predictor.set_miss(v, miss);
    if (projection.is_folded) cell = folded(cell);
    part.normals[v] = {static_cast<std::uint8_t>(cell[0]), static_cast<std::uint8_t>(cell[1])};
  }
}

}  // namespace colossus::codec::predict
