#include "codec/predict/point_predictor.hpp"

namespace colossus::codec::predict {
namespace {

constexpr int kFaceNormalBits = 10;

std::int64_t dot(const LongVector& a, const LongVector& b) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum = wrapped_sum(sum, wrapped_product(a[i], b[i]));
  return sum;
}

}  // namespace

PointPredictor::PointPredictor(const Basis& basis, const Links& links, const coded::CodedNode& node,
                               std::size_t vertex_count)
    : basis_(basis),
      links_(links.of),
      kinds_(links.kinds),
      has_weights_(!node.is_on_lattice()),
      one_(std::uint32_t{1} << (node.position_bits & 31)),
      shift_(std::max(0, node.position_bits - kPlaneBits)),
      points_(vertex_count),
      faces_(vertex_count) {
  if (has_weights_) prepare_faces();
}

void PointPredictor::prepare_faces() {
  // Where each of the weights leads.
  std::array<Vector, 4> ends{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) ends[j][i] = basis_.from_weights[i][j];
  const auto way = [&](std::size_t from, std::size_t to) {
    return Vector{ends[to][0] - ends[from][0], ends[to][1] - ends[from][1], ends[to][2] - ends[from][2]};
  };
  for (std::size_t f = 0; f < 4; ++f) {
    Face& face = all_faces_[f];
    face.origin_weight = f < 3 ? 0 : one_;
    for (std::size_t i = 0; i < 3; ++i)
      face.gradient[i] = f < 3
                             ? basis_.to_weights[f][i]
                             : -(basis_.to_weights[0][i] + basis_.to_weights[1][i] + basis_.to_weights[2][i]);
    face.way = direction_of(face.gradient);
    face.steepness = dot(face.gradient, face.way);
    std::array<std::size_t, 3> free{};
    for (std::size_t i = 0, k = 0; i < 4; ++i)
      if (i != f) free[k++] = i;
    for (std::size_t k = 0; k < 3; ++k) {
      FaceLine& line = face.lines[k];
      const std::size_t third = free[(k + 2) % 3];
      line.first = free[k];
      line.second = free[(k + 1) % 3];
      line.origin = lanes_of(ends[third]) * one_;
      line.first_step = lanes_of(way(third, line.first));
      const Vector second_way = way(third, line.second);
      line.second_step = lanes_of(second_way);
      line.second_way = {second_way[0], second_way[1], second_way[2]};
    }
  }
}

Lanes PointPredictor::point_of(const coded::Coordinates& weights) const {
  const Vector w{static_cast<std::int32_t>(weights[0]), static_cast<std::int32_t>(weights[1]),
                 static_cast<std::int32_t>(weights[2])};
  return lanes_of({wrapped_dot(basis_.from_weights[0], w), wrapped_dot(basis_.from_weights[1], w),
                   wrapped_dot(basis_.from_weights[2], w)});
}

bool PointPredictor::set_weights(std::span<coded::Coordinates> weights) const {
  // Entries are -1, 0 and 1, so that masks do for products.
  std::array<Lanes, 3> masks{};
  std::array<Lanes, 3> signs{};
  Lanes origin{};
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 3; ++i) {
      masks[j][i] = basis_.to_weights[i][j] != 0 ? kAll : 0;
      signs[j][i] = basis_.to_weights[i][j] < 0 ? kAll : 0;
      origin[i] -= signs[j][i];
    }
  const Lanes last{0, 0, 0, has_weights_ ? kAll : 0};
  const Lanes one = Lanes{} + one_;
  Lanes outside{};
  for (std::size_t v = 0; v < weights.size(); ++v) {
    const Lanes p = points_[v];
    outside |= p + kNarrow;
    const Lanes w = origin + ((__builtin_shufflevector(p, p, 0, 0, 0, 0) & masks[0]) ^ signs[0]) +
                    ((__builtin_shufflevector(p, p, 1, 1, 1, 1) & masks[1]) ^ signs[1]) +
                    ((__builtin_shufflevector(p, p, 2, 2, 2, 2) & masks[2]) ^ signs[2]);
    const Lanes pairs = w + __builtin_shufflevector(w, w, 1, 0, 3, 2);
    const Lanes sum = pairs + __builtin_shufflevector(pairs, pairs, 2, 3, 0, 1);
    const Lanes all = w + ((one - sum) & last);
    std::memcpy(&weights[v], &all, sizeof all);
  }
  return (outside[0] | outside[1] | outside[2]) < 2 * kNarrow;
}

Residual PointPredictor::residual_of(const Parallelograms& from, const Lanes& point) const {
  const Plane plane(normal_of(from));
  const Lanes miss = point - from.end;
  const Triple<std::uint32_t> m = rotated<std::uint32_t>(miss[0], miss[1], miss[2], plane.steepest);
  return {m.first, m.second, m.last - plane.height(m.first, m.second)};
}

// The shortest way within the plane is along s * direction(face) + t * direction(plane), where direction()
// makes the vector of a gradient.
FacePrediction PointPredictor::predict_on_face(Lanes end, const LongVector& plane_normal,
                                               std::uint32_t face_index) const {
  const Face& face = all_faces_[face_index];
  const int excess = excess_bits(plane_normal[0], plane_normal[1], plane_normal[2], kFaceNormalBits);
  const LongVector normal{plane_normal[0] >> excess, plane_normal[1] >> excess, plane_normal[2] >> excess};
  const LongVector plane_way = direction_of(normal);
  const std::int64_t a = face.steepness;
  const std::int64_t b = dot(face.way, normal);
  const std::int64_t c = dot(normal, plane_way);
  const std::int64_t area = wrapped_difference(wrapped_product(a, c), wrapped_product(b, b));
  if (area > 0) {
    const auto distance = static_cast<std::int32_t>(weight_of(end, face_index));
    Vector moves{};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t back =
          wrapped_difference(wrapped_product(plane_way[i], b), wrapped_product(face.way[i], c));
      // Two bits less, so that rounding cannot overflow.
      moves[i] =
          static_cast<std::int32_t>(rounded_quotient(wrapped_product(back, distance) >> 2, (area >> 2) + 1));
    }
    end += lanes_of(moves);
  }
  // How steep the plane is along the lines in which a free weight stays as it is.
  std::array<std::int64_t, 4> slopes{};
  for (std::size_t k = 0; k < 3; ++k) slopes[k] = dot(normal, face.lines[k].second_way);
  slopes[3] = slopes[0];
  const std::size_t first = first_greatest(std::abs(slopes[0]), std::abs(slopes[1]), std::abs(slopes[2]));
  FacePrediction result;
  result.line = &face.lines[first];
  result.first = weight_of(end, result.line->first);
  result.second = weight_of(end, result.line->second);
  if (slopes[first] != 0) {
    const std::int64_t slope = slopes[first + 1];
    result.slope_numerator = slopes[first] < 0 ? -slope : slope;
    result.slope_denominator = std::abs(slopes[first]);
  }
  return result;
}

}  // namespace colossus::codec::predict
