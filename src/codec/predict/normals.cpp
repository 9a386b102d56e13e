#include "codec/predict/normals.hpp"

#include <algorithm>
#include <bit>

#include "codec/predict/buffer.hpp"

namespace colossus::codec::predict {
namespace {

// Coordinates keep so many bits, and one for 2^bits itself. Sums over a million triangles fit; what does not,
// wraps.
constexpr int kEdgeBits = 16;
constexpr std::uint32_t kEdgeMask = (2U << kEdgeBits) - 1;
// A component of a sum keeps so many bits when it is projected.
constexpr int kSumBits = 14;

// Sums of face normals at each vertex, by area.
std::vector<LongVector> face_sums(const CodedNode& node, const CodedPart& part) {
  const int shift = std::max(0, node.position_bits - kEdgeBits);
  Buffer<std::array<std::int32_t, 4>> points(part.positions.size());
  std::array<std::array<std::uint32_t, 3>, 3> frame;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t axis = 0; axis < 3; ++axis)
      frame[row][axis] = static_cast<std::uint32_t>(int{part.frame[row][axis]});
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Coordinates& w = part.positions[v];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t sum = 0;
      for (std::size_t row = 0; row < 3; ++row) sum += (w[row] >> shift & kEdgeMask) * frame[row][axis];
      points[v][axis] = static_cast<std::int32_t>(sum);
    }
  }
  std::vector<LongVector> sums(points.size());
  for (const mesh::Triangle& t : part.triangles) {
    const auto& p = points[t[0]];
    LongVector a{};
    LongVector b{};
    for (std::size_t i = 0; i < 3; ++i) {
      a[i] = points[t[1]][i] - p[i];
      b[i] = points[t[2]][i] - p[i];
    }
    const LongVector n{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    for (const std::uint32_t v : t)
      for (std::size_t i = 0; i < 3; ++i) sums[v][i] = wrapped_sum(sums[v][i], n[i]);
  }
  return sums;
}

// Adds to `weight` times each sum those of the neighbours, once per triangle.
std::vector<LongVector> smoothed(const std::vector<LongVector>& sums, const CodedPart& part,
                                 std::int64_t weight) {
  std::vector<LongVector> result(sums.size());
  for (std::size_t v = 0; v < sums.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i) result[v][i] = wrapped_product(weight, sums[v][i]);
  for (const mesh::Triangle& t : part.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t all = wrapped_sum(wrapped_sum(sums[t[0]][i], sums[t[1]][i]), sums[t[2]][i]);
      for (const std::uint32_t v : t)
        result[v][i] = wrapped_sum(result[v][i], wrapped_difference(all, sums[v][i]));
    }
  return result;
}

// A predicted normal in the octahedron's square. Around its lower pole the square is folded over, so that a
// prediction near its border has neighbours on all sides.
struct Projection {
  std::int32_t u = 128;  // the nearest cell, 0 to 255
  std::int32_t v = 128;
  std::int32_t u_sign = 1;  // -1 where the prediction is below the cell's middle
  std::int32_t v_sign = 1;
  bool is_folded = false;
};

inline Projection project(const LongVector& n) {
  Projection projection;
  if ((n[0] | n[1] | n[2]) == 0) return projection;
  const int excess = excess_bits(n[0], n[1], n[2], kSumBits);
  const auto x = static_cast<std::int32_t>(n[0] >> excess);
  const auto y = static_cast<std::int32_t>(n[1] >> excess);
  const auto z = static_cast<std::int32_t>(n[2] >> excess);
  const std::int32_t sum = std::abs(x) + std::abs(y) + std::abs(z);
  projection.is_folded = z < 0;
  // 255 * (x / sum + 1) / 2 in fixed point, with one division for both.
  constexpr int kPoint = 24;
  constexpr std::uint32_t kHalf = 1U << (kPoint - 1);
  const std::uint32_t scale = 255 * kHalf / static_cast<std::uint32_t>(sum);
  const std::uint32_t u = static_cast<std::uint32_t>(x + sum) * scale + kHalf;
  const std::uint32_t v = static_cast<std::uint32_t>(y + sum) * scale + kHalf;
  projection.u = static_cast<std::int32_t>(u >> kPoint);
  projection.v = static_cast<std::int32_t>(v >> kPoint);
  projection.u_sign = (u & (2 * kHalf - 1)) < kHalf ? -1 : 1;
  projection.v_sign = (v & (2 * kHalf - 1)) < kHalf ? -1 : 1;
  return projection;
}

// Its own inverse.
inline void fold(std::int32_t& u, std::int32_t& v) {
  const std::int32_t x = 2 * u - 255;
  const std::int32_t y = 2 * v - 255;
  // Both are odd: signs are 1 and -1, without a branch.
  u = ((256 - std::abs(y)) * ((x >> 31) | 1) + 255) >> 1;
  v = ((256 - std::abs(x)) * ((y >> 31) | 1) + 255) >> 1;
}

constexpr std::int32_t wrapped_byte(std::int32_t value) { return static_cast<std::int8_t>(value & 255); }

std::uint32_t second_context(std::uint8_t kind, std::uint32_t first) {
  return 2 + kNormalSizes * static_cast<std::uint32_t>(is_border(kind)) + class_of(first, 1, 3, 7, 15, 31);
}

struct Miss {
  std::int32_t u = 0;
  std::int32_t v = 0;
};

class Predictor {
 public:
  Predictor(NormalMode mode, const Links& links, const CodedNode& node, const CodedPart& part)
      : links_(links.of), expects_misses_(mode != NormalMode::kSum), sums_(face_sums(node, part)) {
    if (mode == NormalMode::kSmoothed) sums_ = smoothed(sums_, part, 8);
    if (mode == NormalMode::kMoreSmoothed) sums_ = smoothed(sums_, part, 3);
    if (expects_misses_) misses_.resize(sums_.size());
  }

  Projection project_sum(std::uint32_t v) const { return project(sums_[v]); }

  // Half the mean of what the neighbours' projections missed their normals by.
  Miss expected_miss(std::uint32_t v) const {
    if (!expects_misses_ || links_[v].neighbor_count == 0) return {};
    std::int32_t u_sum = 0;
    std::int32_t v_sum = 0;
    for (const std::uint32_t neighbor : links_[v].neighbors) {
      u_sum += misses_[neighbor].u;
      v_sum += misses_[neighbor].v;
    }
    constexpr auto kTwice = static_cast<std::int32_t>(2 * kMostNeighbors);
    return {u_sum / kTwice, v_sum / kTwice};
  }
  void set_miss(std::uint32_t v, const Miss& miss) {
    if (expects_misses_) misses_[v] = miss;
  }

 private:
  std::span<const VertexLinks> links_;
  bool expects_misses_;
  std::vector<LongVector> sums_;
  std::vector<Miss> misses_;
};

// Calls back with what is left of each normal, in order.
template <typename Take>
void for_each_residual(NormalMode mode, const Links& links, const CodedNode& node, const CodedPart& part,
                       Take take) {
  Predictor predictor(mode, links, node, part);
  for (std::uint32_t v = 0; v < part.normals.size(); ++v) {
    const Projection projection = predictor.project_sum(v);
    std::int32_t u_cell = part.normals[v][0];
    std::int32_t v_cell = part.normals[v][1];
    if (projection.is_folded) fold(u_cell, v_cell);
    const Miss expected = predictor.expected_miss(v);
    const Miss miss{wrapped_byte(u_cell - projection.u), wrapped_byte(v_cell - projection.v)};
    predictor.set_miss(v, miss);
    take(v, std::array<std::uint32_t, 2>{to_unsigned(projection.u_sign * wrapped_byte(miss.u - expected.u)),
                                         to_unsigned(projection.v_sign * wrapped_byte(miss.v - expected.v))});
  }
}

}  // namespace

NormalMode choose_normal_mode(const CodedNode& node, const std::vector<Links>& links) {
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

void encode_normals(ValueEncoder& values, NormalMode mode, const Links& links, const CodedNode& node,
                    const CodedPart& part) {
  std::vector<std::array<std::uint32_t, 2>> residuals(part.normals.size());
  for_each_residual(mode, links, node, part,
                    [&](std::uint32_t v, const std::array<std::uint32_t, 2>& r) { residuals[v] = r; });
  for (std::size_t v = 0; v < residuals.size(); ++v)
    values.put(is_border(links.kinds[v]) ? 1 : 0, residuals[v][0]);
  values.end_batch();
  for (std::size_t v = 0; v < residuals.size(); ++v)
    values.put(second_context(links.kinds[v], residuals[v][0]), residuals[v][1]);
  values.end_batch();
}

void decode_normals(ValueDecoder& values, NormalMode mode, const Links& links, const CodedNode& node,
                    CodedPart& part) {
  const std::size_t count = part.normals.size();
  Buffer<std::uint32_t> first(count);
  Buffer<std::uint32_t> second(count);
  values.get_batch(first.all(), [&](std::size_t v) { return is_border(links.kinds[v]) ? 1U : 0U; });
  values.get_batch(second.all(), [&](std::size_t v) { return second_context(links.kinds[v], first[v]); });
  Predictor predictor(mode, links, node, part);
  for (std::uint32_t v = 0; v < count; ++v) {
    const Projection projection = predictor.project_sum(v);
    const Miss expected = predictor.expected_miss(v);
    const Miss miss{wrapped_byte(projection.u_sign * wrapped_byte(to_signed(first[v])) + expected.u),
                    wrapped_byte(projection.v_sign * wrapped_byte(to_signed(second[v])) + expected.v)};
    predictor.set_miss(v, miss);
    std::int32_t u_cell = (projection.u + miss.u) & 255;
    std::int32_t v_cell = (projection.v + miss.v) & 255;
    if (projection.is_folded) fold(u_cell, v_cell);
    part.normals[v][0] = static_cast<std::uint8_t>(u_cell);
    part.normals[v][1] = static_cast<std::uint8_t>(v_cell);
  }
}

}  // namespace colossus::codec::predict
