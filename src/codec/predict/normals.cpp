#include "codec/predict/normals.hpp"

#include <cstdlib>

#include "codec/predict/buffer.hpp"
#include "codec/predict/face_sums.hpp"
#include "codec/predict/projections.hpp"

namespace colossus::codec::predict {
namespace {

// Its own inverse.
constexpr void fold(std::int32_t& u, std::int32_t& v) {
  const std::int32_t x = 2 * u - 255;
  const std::int32_t y = 2 * v - 255;
  // Both are odd: signs are 1 and -1, without a branch.
  u = ((256 - std::abs(y)) * ((x >> 31) | 1) + 255) >> 1;
  v = ((256 - std::abs(x)) * ((y >> 31) | 1) + 255) >> 1;
}

std::uint32_t first_context(std::uint8_t kind) { return is_border(kind) ? 1 : 0; }
std::uint32_t second_context(std::uint8_t kind, std::uint32_t first) {
  return 2 + kNormalSizes * static_cast<std::uint32_t>(is_border(kind)) + class_of(first, 1, 3, 7, 15, 31);
}

std::int32_t own_weight(NormalMode mode) {
  if (mode == NormalMode::kSmoothed) return 8;
  return mode == NormalMode::kMoreSmoothed ? 3 : 0;
}

// What a projection missed the normal by, u and v in lanes of 16 bits: a byte each, 128 more than it is.
using Miss = std::uint32_t;
constexpr Miss kEachLane = 0x00010001;
constexpr std::uint32_t kOffset = 128;

constexpr Miss to_miss(std::uint32_t u, std::uint32_t v) {
  return ((u + kOffset) & 255) | ((v + kOffset) & 255) << 16;
}

// Adds to it half the mean of the neighbours' misses, rounded towards zero.
Miss with_expected_miss(Miss miss, const Links& links, std::size_t vertex, const Miss* misses) {
  if (neighbors_of(links.kinds[vertex]) == 0) return miss;
  const auto& [p, q, r, s] = links.of[vertex].neighbors;
  const Miss sum = (misses[p] + misses[q]) + (misses[r] + misses[s]);
  // Four offsets make 2^9: a sum that has this bit is not negative, and rounded down.
  const Miss not_negative = sum >> 9 & kEachLane;
  const Miss rounded_up = (sum + 7 * kEachLane + not_negative) >> 3 & 255 * kEachLane;
  // In this order, since vertices wait for what those just before them yield, which is in the sum.
  constexpr std::uint32_t kOffsets = kMostNeighbors * kOffset / 8;
  return ((miss + (256 - kOffsets) * kEachLane - not_negative) + rounded_up) & 255 * kEachLane;
}

constexpr coded::OctahedralNormal normal_of(std::uint32_t u_projection, std::uint32_t v_projection,
                                            Miss miss) {
  const auto u = static_cast<std::int32_t>((nearest_cell(u_projection) + miss - kOffset) & 255);
  const auto v = static_cast<std::int32_t>((nearest_cell(v_projection) + (miss >> 16) - kOffset) & 255);
  std::int32_t u_folded = u;
  std::int32_t v_folded = v;
  fold(u_folded, v_folded);
  const std::int32_t mask = fold_mask(u_projection);
  return {static_cast<std::uint8_t>((u_folded & mask) | (u & ~mask)),
          static_cast<std::uint8_t>((v_folded & mask) | (v & ~mask))};
}

// Calls back with what is left of each normal, in order.
template <typename Take>
void for_each_residual(NormalMode mode, const Links& links, const coded::CodedNode& node,
                       const coded::CodedPart& part, Take take) {
  const Projections projections = project(face_sums(node.position_bits, part, own_weight(mode)));
  Buffer<Miss> misses(part.normals.size());
  for (std::uint32_t i = 0; i < part.normals.size(); ++i) {
    const std::uint32_t u = projections.u[i];
    const std::uint32_t v = projections.v[i];
    std::int32_t u_cell = part.normals[i][0];
    std::int32_t v_cell = part.normals[i][1];
    if (fold_mask(u) != 0) fold(u_cell, v_cell);
    misses[i] = to_miss(static_cast<std::uint32_t>(u_cell) - nearest_cell(u),
                        static_cast<std::uint32_t>(v_cell) - nearest_cell(v));
    const Miss none = to_miss(0, 0);
    const Miss expected = mode == NormalMode::kSum ? none : with_expected_miss(none, links, i, &misses[0]);
    const auto residual = [](std::uint32_t place, std::uint32_t rest) {
      const auto wrapped = static_cast<std::uint32_t>(static_cast<std::int8_t>(rest & 255));
      return to_unsigned(static_cast<std::int32_t>(with_sign_of(place, wrapped)));
    };
    // Lanes stay above zero.
    const Miss rest = misses[i] + 256 * kEachLane - expected;
    take(i, std::array<std::uint32_t, 2>{residual(u, rest), residual(v, rest >> 16)});
  }
}

}  // namespace

NormalMode choose_normal_mode(const coded::CodedNode& node, const std::vector<Links>& links) {
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

void encode_normals(ValueEncoder& values, NormalMode mode, const Links& links, const coded::CodedNode& node,
                    const coded::CodedPart& part) {
  std::vector<std::array<std::uint32_t, 2>> residuals(part.normals.size());
  for_each_residual(mode, links, node, part,
                    [&](std::uint32_t v, const std::array<std::uint32_t, 2>& r) { residuals[v] = r; });
  for (std::size_t v = 0; v < residuals.size(); ++v)
    values.put(first_context(links.kinds[v]), residuals[v][0]);
  values.end_batch();
  for (std::size_t v = 0; v < residuals.size(); ++v)
    values.put(second_context(links.kinds[v], residuals[v][0]), residuals[v][1]);
  values.end_batch();
}

void decode_normals(ValueDecoder& values, NormalMode mode, const Links& links, const coded::CodedNode& node,
                    coded::CodedPart& part) {
  const std::size_t count = part.normals.size();
  Buffer<std::uint32_t> first(count);
  Buffer<std::uint32_t> second(count);
  values.get_batch(first.all(), [&](std::size_t i) { return first_context(links.kinds[i]); });
  Buffer<std::uint8_t> contexts(count);
  for (std::size_t i = 0; i < count; ++i)
    contexts[i] = static_cast<std::uint8_t>(second_context(links.kinds[i], first[i]));
  values.get_batch(second.all(), [&](std::size_t i) { return contexts[i]; });
  const Projections projections = project(face_sums(node.position_bits, part, own_weight(mode)));
  const std::uint32_t* const us = &projections.u[0];
  const std::uint32_t* const vs = &projections.v[0];
  Buffer<Miss> buffer(count);
  Miss* const misses = &buffer[0];
  for (std::size_t i = 0; i < count; ++i) {
    const auto u = static_cast<std::uint32_t>(to_signed(first[i]));
    const auto v = static_cast<std::uint32_t>(to_signed(second[i]));
    misses[i] = to_miss(with_sign_of(us[i], u), with_sign_of(vs[i], v));
  }
  if (mode != NormalMode::kSum)
    for (std::size_t i = 0; i < count; ++i) misses[i] = with_expected_miss(misses[i], links, i, misses);
  coded::OctahedralNormal* const normals = part.normals.data();
  for (std::size_t i = 0; i < count; ++i) normals[i] = normal_of(us[i], vs[i], misses[i]);
}

}  // namespace colossus::codec::predict
