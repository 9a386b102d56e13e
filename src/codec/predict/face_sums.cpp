#include "codec/predict/face_sums.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "codec/predict/basis.hpp"

namespace colossus::codec::predict {
namespace {

// Four numbers at a time, in the vectors that GCC and Clang have on any machine.
using Float4 [[gnu::vector_size(16)]] = float;
using Int4 [[gnu::vector_size(16)]] = std::int32_t;
using Word4 [[gnu::vector_size(16)]] = std::uint32_t;

template <typename Vector4, typename Array4>
Vector4 load(const Array4& array) {
  static_assert(sizeof(Vector4) == sizeof(Array4));
  Vector4 result;
  std::memcpy(&result, std::assume_aligned<alignof(Array4)>(&array), sizeof result);
  return result;
}
template <typename Array4, typename Vector4>
void store(Array4& array, const Vector4& value) {
  static_assert(sizeof(Vector4) == sizeof(Array4));
  std::memcpy(std::assume_aligned<alignof(Array4)>(&array), &value, sizeof value);
}

// In space, and 0.
struct alignas(16) WorldPoint {
  std::array<float, 4> coordinates;
};

// Coordinates keep so many bits, and one for 2^bits itself: what a frame makes of them is below 2^20, which
// is exact, and so are differences.
constexpr int kEdgeBits = 16;
constexpr std::uint32_t kEdgeMask = (2U << kEdgeBits) - 1;

Buffer<WorldPoint> world_points(int position_bits, const coded::CodedPart& part) {
  const int shift = std::max(0, position_bits - kEdgeBits);
  std::array<Float4, 3> frame{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t axis = 0; axis < 3; ++axis) frame[row][axis] = part.frame[row][axis];
  Buffer<WorldPoint> points(part.positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Word4 kept = load<Word4>(part.positions[v]) >> shift & kEdgeMask;
    const Float4 w = __builtin_convertvector(std::bit_cast<Int4>(kept), Float4);
    store(points[v], w[0] * frame[0] + w[1] * frame[1] + w[2] * frame[2]);
  }
  return points;
}

// y, z, x and the last.
Float4 rotated(const Float4& a) { return __builtin_shufflevector(a, a, 1, 2, 0, 3); }
Float4 least_of(const Float4& a, const Float4& b) { return a < b ? a : b; }
Float4 most_of(const Float4& a, const Float4& b) { return b < a ? a : b; }

// What bounds the numbers that a narrow sum is made of.
constexpr float kLongestEdge = 1448;          // components of normals are below 2 * 1448^2 < 2^22
constexpr std::int32_t kMostTriangles = 511;  // at a vertex: components of sums are below 2^31

// Products of edges, and their differences, are exact in 24 bits, and sums in 32, where edges are short and
// triangles at a vertex few; both is found out on the way. Numbers without sign, since they may wrap before.
std::optional<Buffer<FaceSum>> narrow_sums(const Buffer<WorldPoint>& points, const coded::CodedPart& part) {
  Buffer<FaceSum> sums(points.size());
  std::fill_n(sums.all().begin(), sums.size(), FaceSum{});
  // The bits of 1.5 * 2^23 plus a whole number, of less than 2^22 either way, are those of 1.5 * 2^23 plus
  // that number: a conversion that is defined for greater ones, too, though of no use. The last component
  // counts triangles.
  constexpr float kAnchor = 3 << 22;
  const std::uint32_t anchor = std::bit_cast<std::uint32_t>(kAnchor);
  const Word4 from_anchor = Word4{0, 0, 0, 1} - anchor;
  Float4 least{};
  Float4 most{};
  for (const mesh::Triangle& t : part.triangles) {
    const std::uint32_t i = t[0];
    const std::uint32_t j = t[1];
    const std::uint32_t k = t[2];
    const auto p = load<Float4>(points[i]);
    const Float4 a = load<Float4>(points[j]) - p;
    const Float4 b = load<Float4>(points[k]) - p;
    least = least_of(least_of(least, a), b);
    most = most_of(most_of(most, a), b);
    const Float4 normal = a * rotated(b) - rotated(a) * b + kAnchor;
    const Word4 whole = std::bit_cast<Word4>(normal) + from_anchor;
    for (const std::uint32_t v : {i, j, k}) store(sums[v], load<Word4>(sums[v]) + whole);
  }
  bool is_narrow = true;
  for (int i = 0; i < 3; ++i) is_narrow = is_narrow && most[i] <= kLongestEdge && least[i] >= -kLongestEdge;
  if (!is_narrow) return std::nullopt;
  return sums;
}

// Bits of all sums, signs apart: no component is above them.
Int4 bits_of(const Buffer<FaceSum>& sums) {
  Int4 bits{};
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const auto sum = load<Int4>(sums[v]);
    bits |= sum ^ sum >> 31;
  }
  return bits;
}

// Adds to `own_weight` times each sum those of the neighbours, once per triangle.
Buffer<FaceSum> smoothed(const Buffer<FaceSum>& sums, const coded::CodedPart& part, std::int32_t own_weight) {
  Buffer<FaceSum> result(sums.size());
  for (std::size_t v = 0; v < sums.size(); ++v)
    store(result[v], load<Word4>(sums[v]) * static_cast<std::uint32_t>(own_weight));
  for (const mesh::Triangle& t : part.triangles) {
    const std::uint32_t i = t[0];
    const std::uint32_t j = t[1];
    const std::uint32_t k = t[2];
    const auto p = load<Word4>(sums[i]);
    const auto q = load<Word4>(sums[j]);
    const auto r = load<Word4>(sums[k]);
    store(result[i], load<Word4>(result[i]) + (q + r));
    store(result[j], load<Word4>(result[j]) + (r + p));
    store(result[k], load<Word4>(result[k]) + (p + q));
  }
  return result;
}

// As above, in any case.
std::vector<LongVector> wide_sums(const Buffer<WorldPoint>& points, const coded::CodedPart& part) {
  std::vector<LongVector> sums(points.size());
  for (const mesh::Triangle& t : part.triangles) {
    LongVector a{};
    LongVector b{};
    for (std::size_t i = 0; i < 3; ++i) {
      const float p = points[t[0]].coordinates[i];
      a[i] = static_cast<std::int64_t>(points[t[1]].coordinates[i] - p);
      b[i] = static_cast<std::int64_t>(points[t[2]].coordinates[i] - p);
    }
    const LongVector n{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    for (const std::uint32_t v : t)
      for (std::size_t i = 0; i < 3; ++i) sums[v][i] = wrapped_sum(sums[v][i], n[i]);
  }
  return sums;
}

std::vector<LongVector> smoothed(const std::vector<LongVector>& sums, const coded::CodedPart& part,
                                 std::int64_t own_weight) {
  std::vector<LongVector> result(sums.size());
  for (std::size_t v = 0; v < sums.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i) result[v][i] = wrapped_product(own_weight, sums[v][i]);
  for (const mesh::Triangle& t : part.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t all = wrapped_sum(wrapped_sum(sums[t[0]][i], sums[t[1]][i]), sums[t[2]][i]);
      for (const std::uint32_t v : t)
        result[v][i] = wrapped_sum(result[v][i], wrapped_difference(all, sums[v][i]));
    }
  return result;
}

}  // namespace

std::optional<Buffer<FaceSum>> narrow_face_sums(int position_bits, const coded::CodedPart& part,
                                                std::int32_t own_weight) {
  auto sums = narrow_sums(world_points(position_bits, part), part);
  if (!sums) return std::nullopt;
  const Int4 bits = bits_of(*sums);
  if (bits[3] > kMostTriangles) return std::nullopt;
  if (own_weight == 0) return sums;
  // A triangle adds two sums.
  const std::int64_t most = std::int64_t{bits[0] | bits[1] | bits[2]} + 1;
  if (most * (own_weight + 2 * bits[3]) > std::numeric_limits<std::int32_t>::max()) return std::nullopt;
  return smoothed(*sums, part, own_weight);
}

Buffer<FaceSum> wide_face_sums(int position_bits, const coded::CodedPart& part, std::int32_t own_weight) {
  std::vector<LongVector> sums = wide_sums(world_points(position_bits, part), part);
  if (own_weight > 0) sums = smoothed(sums, part, own_weight);
  Buffer<FaceSum> result(sums.size());
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const auto& [x, y, z] = sums[v];
    const int excess = excess_bits(x, y, z, kSumBits);
    result[v].components = {static_cast<std::int32_t>(z >> excess), static_cast<std::int32_t>(x >> excess),
                            static_cast<std::int32_t>(y >> excess), 0};
  }
  return result;
}

Buffer<FaceSum> face_sums(int position_bits, const coded::CodedPart& part, std::int32_t own_weight) {
  if (auto sums = narrow_face_sums(position_bits, part, own_weight)) return std::move(*sums);
  return wide_face_sums(position_bits, part, own_weight);
}

}  // namespace colossus::codec::predict
