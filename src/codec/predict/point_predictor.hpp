// How positions.hpp predicts: the parallelograms that lead to a point, the plane through it, and the faces of
// the tetrahedron.
//
// A point is four numbers side by side in a vector, which compilers turn into the instructions of whatever
// processor. All of it is integers that wrap; only where these are small enough for doubles to hold them
// exactly, which is nearly always, a point is found in doubles, in a third of the time (narrow_point_at()).
#pragma once

#include <bit>
#include <cmath>
#include <cstring>

#include "codec/predict/basis.hpp"
#include "codec/predict/buffer.hpp"
#include "codec/predict/traversal.hpp"

namespace colossus::codec::predict {

inline constexpr std::uint32_t kNoFace = 4;
// Wider coordinates are too coarse a measure of a plane than this many bits are.
inline constexpr int kPlaneBits = 18;
inline constexpr int kNormalBits = 28;

// Coordinates x y z x: the second x spares cross products a shuffle.
using Lanes = std::uint32_t __attribute__((vector_size(16)));
using SignedLanes = std::int32_t __attribute__((vector_size(16)));
using Pair = double __attribute__((vector_size(16)));
using Quad = double __attribute__((vector_size(32)));

inline Lanes lanes_of(const Vector& point) {
  const auto x = static_cast<std::uint32_t>(point[0]);
  return Lanes{x, static_cast<std::uint32_t>(point[1]), static_cast<std::uint32_t>(point[2]), x};
}

// Of numbers that are not negative. Without a branch, which would be a guess.
template <typename T>
std::size_t first_greatest(T a, T b, T c) {
  const bool is_third = c > std::max(a, b);
  const bool is_second = b > a;
  return static_cast<std::size_t>(is_third) * 2 + static_cast<std::size_t>(is_second & !is_third);
}

// Coordinates in an order in which the plane's steepest comes last: x y z, y z x or z x y. Chosen by
// conditional moves; indexed arrays would go through memory.
template <typename T>
struct Triple {
  T first;
  T second;
  T last;
};
template <typename T>
Triple<T> rotated(T x, T y, T z, std::size_t steepest) {
  const bool is_x = steepest == 0;
  const bool is_y = steepest == 1;
  return {is_x ? y : is_y ? z : x, is_x ? z : is_y ? x : y, is_x ? x : is_y ? y : z};
}

// Its normal in no more than kNormalBits, and the axis along which it is steepest.
struct Plane {
  Triple<std::int64_t> normal;  // rotated
  std::size_t steepest = 0;

  explicit Plane(const LongVector& n) {
    const int excess = excess_bits(n[0], n[1], n[2], kNormalBits);
    const std::int64_t x = n[0] >> excess;
    const std::int64_t y = n[1] >> excess;
    const std::int64_t z = n[2] >> excess;
    steepest = first_greatest(std::abs(x), std::abs(y), std::abs(z));
    normal = rotated(x, y, z, steepest);
  }

  // At the given distances from the predicted point.
  std::uint32_t height(std::uint32_t first, std::uint32_t second) const {
    if (normal.last == 0) return 0;
    const std::int64_t rise =
        normal.first * static_cast<std::int32_t>(first) + normal.second * static_cast<std::int32_t>(second);
    return static_cast<std::uint32_t>(
        rounded_quotient(normal.last < 0 ? rise : -rise, std::abs(normal.last)));
  }
};

// The point that parallelograms lead to, and the edges of the triangle that the first continues.
struct Parallelograms {
  Lanes end{};
  SignedLanes first_edge{};
  SignedLanes second_edge{};
};

// Where a point is as seen from the end of the parallelograms: along two axes, and along the steepest from
// the plane on. The axes' order is y z x, z x y or x y z. Signed numbers as unsigned ones, which wrap.
struct Residual {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  std::uint32_t across = 0;
};

// The same on a face: two of the weights, the second from the plane on.
struct FaceResidual {
  std::uint32_t first = 0;
  std::uint32_t across = 0;
};

// One of the orders of a face's free weights, and where they lead.
struct FaceLine {
  std::size_t first = 0;
  std::size_t second = 0;
  Lanes origin{};  // where the third is all
  Lanes first_step{};
  Lanes second_step{};
  LongVector second_way{};  // second_step
};

// What a face adds to a part.
struct Face {
  LongVector gradient{};  // of the weight that is 0 on it
  std::uint32_t origin_weight = 0;
  LongVector way{};  // the shortest to the face
  std::int64_t steepness = 0;
  std::array<FaceLine, 3> lines;
};

struct FacePrediction {
  const FaceLine* line = nullptr;
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  std::int64_t slope_numerator = 0;  // of the second against the first
  std::int64_t slope_denominator = 1;

  std::uint32_t height(std::uint32_t along) const {
    return static_cast<std::uint32_t>(
        rounded_quotient(slope_numerator * static_cast<std::int32_t>(along), slope_denominator));
  }
  FaceResidual residual_of(const coded::Coordinates& weights) const {
    const std::uint32_t along = weights[line->first] - first;
    return {along, weights[line->second] - second - height(along)};
  }
  Lanes point_at(const FaceResidual& residual) const {
    const std::uint32_t along = residual.first;
    return line->origin + line->first_step * (first + along) +
           line->second_step * (second + residual.across + height(along));
  }
};

// Points within it are at least -kNarrow and less than kNarrow: edges are then below 2^19, normals below
// 2^39.
inline constexpr std::uint32_t kNarrow = 1 << kPlaneBits;
inline constexpr double kNormalLimit = 1 << kNormalBits;
// No plane is higher above a narrow point: the predicted point is below 3 * kNarrow, so it is less than
// 4 * kNarrow away along each of two axes, and along the third the plane rises by no more.
inline constexpr std::uint32_t kHeightLimit = 8 * kNarrow + 2;

class PointPredictor {
 public:
  PointPredictor(const Basis& basis, const Links& links, const coded::CodedNode& node,
                 std::size_t vertex_count);

  bool may_be_on_face(std::uint32_t v) const { return has_weights_ && is_border(kinds_[v]); }
  // On which faces the neighbours that come before are; bits.
  std::uint32_t neighbor_faces(std::uint32_t v) const {
    const auto& neighbors = links_[v].neighbors;
    const auto faces = static_cast<std::uint32_t>(faces_[neighbors[0]] | faces_[neighbors[1]] |
                                                  faces_[neighbors[2]] | faces_[neighbors[3]]);
    return neighbors_of(kinds_[v]) == 0 ? 0 : faces;
  }
  void set_face(std::uint32_t v, std::uint32_t face) {
    faces_[v] = static_cast<std::uint8_t>(face == kNoFace ? 0 : 1U << face);
  }
  bool is_on_face(std::uint32_t v) const { return faces_[v] != 0; }
  std::uint32_t face_of(std::uint32_t v) const {
    return static_cast<std::uint32_t>(std::countr_zero(faces_[v]));
  }

  void set_point(std::uint32_t v, const Lanes& point) { points_[v] = point; }
  Lanes point_of(const coded::Coordinates& weights) const;
  // Of all points; whether these are narrow.
  bool set_weights(std::span<coded::Coordinates> weights) const;

  Parallelograms parallelograms(std::uint32_t v) const {
    const VertexLinks& links = links_[v];
    if (relations_of(kinds_[v]) == 0) return {v > 0 ? points_[v - 1] : Lanes{}, SignedLanes{}, SignedLanes{}};
    const Lanes p = points_[links.relations[0].first];
    const Lanes q = points_[links.relations[0].second];
    const Lanes r = points_[links.relations[0].opposite];
    const Lanes first = p + q - r;
    // The mean of the parallelograms' ends, of which the first counts twice.
    const Lanes sum = first + first + end_of(links.relations[1]) + end_of(links.relations[2]);
    return {reinterpret_cast<Lanes>(reinterpret_cast<SignedLanes>(sum + 2U) >> 2),
            reinterpret_cast<SignedLanes>(q - p), reinterpret_cast<SignedLanes>(r - p)};
  }

  Residual residual_of(const Parallelograms& from, const Lanes& point) const;
  // In line, as is what it calls: else narrow_point_at() would keep all in memory, to be able to call it.
  Lanes point_at(const Parallelograms& from, const Residual& residual) const {
    const Plane plane(normal_of(from));
    const std::uint32_t last = residual.across + plane.height(residual.first, residual.second);
    return from.end + ((kFirstLane[plane.steepest] & residual.first) |
                       (kSecondLane[plane.steepest] & residual.second) | (kLastLane[plane.steepest] & last));
  }

  // point_at(), if position_bits are at most kPlaneBits, the points before are narrow, and the result is;
  // else any point that is not narrow. Then numerator and denominator are integers below 2^53, and exact. A
  // quotient a / b of such, rounded, has the whole part of the true one: that is an integer itself, or 1 / b
  // away from the next at least, and rounding moves it by less, a / b / 2^53. Of wild residuals, too, it is
  // below 2^34, since no normal is greater than the last.
  Lanes narrow_point_at(const Parallelograms& from, const Residual& residual) const {
    const NarrowNormal normal = narrow_normal(from);
    const double x_size = std::abs(normal.zx[1]);
    const double y_size = std::abs(normal.yz[0]);
    const double z_size = std::abs(normal.zx[0]);
    const double size = std::max(z_size, std::max(x_size, y_size));
    if (size == 0 || size >= kNormalLimit) return point_at(from, residual);
    // y z x y z, of which the steepest is the last of three: from 0 on for x, from 1 for y, from 2 for z.
    alignas(16) std::array<double, 5> normals;
    std::memcpy(&normals[0], &normal.yz, sizeof normal.yz);
    std::memcpy(&normals[1], &normal.zx, sizeof normal.zx);
    std::memcpy(&normals[3], &normal.yz, sizeof normal.yz);
    const std::size_t steepest = first_greatest(x_size, y_size, z_size);
    const double last = normals[steepest + 2];
    const double rise = normals[steepest] * static_cast<std::int32_t>(residual.first) +
                        normals[steepest + 1] * static_cast<std::int32_t>(residual.second);
    // rounded_quotient() of -rise and last, kHeightLimit too high, so that it is no less than 0.
    const double quotient = (last * (2 * kHeightLimit + 1) - 2 * rise) / (2 * last);
    const auto height = static_cast<std::uint32_t>(static_cast<std::int64_t>(quotient)) - kHeightLimit;
    return from.end + ((kFirstLane[steepest] & residual.first) | (kSecondLane[steepest] & residual.second) |
                       (kLastLane[steepest] & (residual.across + height)));
  }

  // On what the parallelograms' plane and the face have in common.
  FacePrediction predict_on_face(Lanes end, const LongVector& plane_normal, std::uint32_t face) const;

  LongVector normal_of(const Parallelograms& from) const {
    const SignedLanes a = from.first_edge >> shift_;
    const SignedLanes b = from.second_edge >> shift_;
    const std::int64_t ax = a[0];
    const std::int64_t ay = a[1];
    const std::int64_t az = a[2];
    const std::int64_t bx = b[0];
    const std::int64_t by = b[1];
    const std::int64_t bz = b[2];
    return {wrapped_difference(ay * bz, az * by), wrapped_difference(az * bx, ax * bz),
            wrapped_difference(ax * by, ay * bx)};
  }
  // The same of narrow edges.
  static LongVector narrow_normal_of(const Parallelograms& from) {
    const NarrowNormal normal = narrow_normal(from);
    return {static_cast<std::int64_t>(normal.zx[1]), static_cast<std::int64_t>(normal.yz[0]),
            static_cast<std::int64_t>(normal.zx[0])};
  }

 private:
  // Where the numbers of a residual belong, by the steepest axis.
  static constexpr std::uint32_t kAll = ~std::uint32_t{0};
  static constexpr Lanes kX{kAll, 0, 0, kAll};
  static constexpr Lanes kY{0, kAll, 0, 0};
  static constexpr Lanes kZ{0, 0, kAll, 0};
  static constexpr std::array<Lanes, 3> kFirstLane{kY, kZ, kX};
  static constexpr std::array<Lanes, 3> kSecondLane{kZ, kX, kY};
  static constexpr std::array<Lanes, 3> kLastLane{kX, kY, kZ};

  struct NarrowNormal {
    Pair zx;
    Pair yz;
  };
  static NarrowNormal narrow_normal(const Parallelograms& from) {
    const Quad a = __builtin_convertvector(from.first_edge, Quad);
    const Quad b = __builtin_convertvector(from.second_edge, Quad);
    const Pair a_xy = __builtin_shufflevector(a, a, 0, 1);
    const Pair a_zx = __builtin_shufflevector(a, a, 2, 3);
    const Pair a_yz = __builtin_shufflevector(a_xy, a_zx, 1, 2);
    const Pair b_xy = __builtin_shufflevector(b, b, 0, 1);
    const Pair b_zx = __builtin_shufflevector(b, b, 2, 3);
    const Pair b_yz = __builtin_shufflevector(b_xy, b_zx, 1, 2);
    return {a_xy * b_yz - a_yz * b_xy, a_zx * b_xy - a_xy * b_zx};
  }

  Lanes end_of(const Relation& relation) const {
    return points_[relation.first] + points_[relation.second] - points_[relation.opposite];
  }
  void prepare_faces();
  LongVector direction_of(const LongVector& gradient) const {
    LongVector direction{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) direction[i] += basis_.metric[i][j] * gradient[j];
    return direction;
  }
  // That is 0 on face i, of any point.
  std::uint32_t weight_of(const Lanes& point, std::size_t i) const {
    const Face& face = all_faces_[i];
    std::uint32_t weight = face.origin_weight;
    for (std::size_t k = 0; k < 3; ++k) weight += static_cast<std::uint32_t>(face.gradient[k]) * point[k];
    return weight;
  }

  const Basis& basis_;
  std::span<const VertexLinks> links_;
  std::span<const std::uint8_t> kinds_;
  bool has_weights_;
  std::uint32_t one_;
  int shift_;
  Buffer<Lanes> points_;
  std::vector<std::uint8_t> faces_;  // bits
  std::array<Face, 4> all_faces_;
};

}  // namespace colossus::codec::predict
