#include "codec/predict/positions.hpp"

#include "codec/predict/buffer.hpp"

namespace colossus::codec::predict {
namespace {

constexpr std::uint32_t kNoFace = 4;
// Wider coordinates are too coarse a measure of a plane than this many bits are.
constexpr int kPlaneBits = 18;
constexpr int kNormalBits = 28;
constexpr int kFaceNormalBits = 10;

// Contexts of values.
constexpr std::uint32_t kAlong = 0;        // by the number of parallelograms
constexpr std::uint32_t kAcross = 4;       // by the size of the two before
constexpr std::uint32_t kFaceAlong = 8;    // by whether there is a parallelogram
constexpr std::uint32_t kFaceAcross = 10;  // by the size of the one before

std::uint32_t magnitude(std::uint32_t value) { return (value >> 1) + (value & 1U); }

std::uint32_t across_context(std::uint32_t first, std::uint32_t second) {
  const std::uint32_t size = std::max(magnitude(first), magnitude(second));
  return kAcross + class_of(size, 4, 12, 40);
}
std::uint32_t face_across_context(std::uint32_t along) {
  const std::uint32_t size = magnitude(along);
  return kFaceAcross + class_of(size, 4, 24);
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
Triple<T> rotated(T x, T y, T z, std::uint32_t steepest) {
  const bool is_x = steepest == 0;
  const bool is_y = steepest == 1;
  return {is_x ? y : is_y ? z : x, is_x ? z : is_y ? x : y, is_x ? x : is_y ? y : z};
}
template <typename T>
Triple<T> unrotated(T first, T second, T last, std::uint32_t steepest) {
  const bool is_x = steepest == 0;
  const bool is_y = steepest == 1;
  return {is_x   ? last
          : is_y ? second
                 : first,
          is_x   ? first
          : is_y ? last
                 : second,
          is_x   ? second
          : is_y ? first
                 : last};
}

// A plane, and the point on it that parallelograms lead to.
struct Prediction {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  std::int64_t x_normal = 0;
  std::int64_t y_normal = 0;
  std::int64_t z_normal = 0;
  std::uint32_t steepest = 0;
};

// A face of the tetrahedron as a target: which weights are free, which of them is coded first, and where.
struct FacePrediction {
  std::array<std::size_t, 3> free{};
  std::size_t first = 0;
  std::size_t second = 0;
  Coordinates point{};
  std::int64_t slope_numerator = 0;  // of the second against the first
  std::int64_t slope_denominator = 1;
};

class Predictor {
 public:
  // Unsigned, so that they wrap.
  using Point = std::array<std::uint32_t, 3>;

  Predictor(const Basis& basis, const Links& links, const CodedNode& node, std::size_t vertex_count)
      : basis_(basis),
        links_(links.of),
        kinds_(links.kinds),
        is_cube_(node.is_cube),
        one_(std::uint32_t{1} << (node.position_bits & 31)),
        shift_(std::max(0, node.position_bits - kPlaneBits)),
        points_(vertex_count),
        faces_(vertex_count) {}

  bool may_be_on_face(std::uint32_t v) const { return !is_cube_ && is_border(kinds_[v]); }

  // On which faces the neighbours that come before are; bits.
  std::uint32_t neighbor_faces(std::uint32_t v) const {
    std::uint32_t faces = 0;
    for (std::size_t i = 0; i < links_[v].neighbor_count; ++i) faces |= faces_[links_[v].neighbors[i]];
    return faces;
  }

  // The only weight that is 0, or kNoFace.
  static std::uint32_t face_of(const Coordinates& weights) {
    std::uint32_t face = kNoFace;
    for (std::uint32_t i = 0; i < 4; ++i) {
      if (weights[i] != 0) continue;
      if (face != kNoFace) return kNoFace;
      face = i;
    }
    return face;
  }
  void set_face(std::uint32_t v, std::uint32_t face) {
    faces_[v] = static_cast<std::uint8_t>(face == kNoFace ? 0 : 1U << face);
  }

  Vector point_of(const Coordinates& weights) const {
    const Vector w{static_cast<std::int32_t>(weights[0]), static_cast<std::int32_t>(weights[1]),
                   static_cast<std::int32_t>(weights[2])};
    return {wrapped_dot(basis_.from_weights[0], w), wrapped_dot(basis_.from_weights[1], w),
            wrapped_dot(basis_.from_weights[2], w)};
  }
  Coordinates weights_of(const Vector& point) const {
    Coordinates weights{};
    std::uint32_t left = one_;
    for (std::size_t i = 0; i < 3; ++i) {
      weights[i] = static_cast<std::uint32_t>(wrapped_dot(basis_.to_weights[i], point));
      left -= weights[i];
    }
    weights[3] = is_cube_ ? 0 : left;
    return weights;
  }
  void set_point(std::uint32_t v, const Vector& point) {
    for (std::size_t i = 0; i < 3; ++i) points_[v][i] = static_cast<std::uint32_t>(point[i]);
  }

  // In line, or the prediction would go through memory.
  [[gnu::always_inline]] Prediction predict(std::uint32_t v) const {
    Prediction prediction;
    const VertexLinks& links = links_[v];
    if (links.relation_count == 0) {
      if (v == 0) return prediction;
      prediction.x = static_cast<std::int32_t>(points_[v - 1][0]);
      prediction.y = static_cast<std::int32_t>(points_[v - 1][1]);
      prediction.z = static_cast<std::int32_t>(points_[v - 1][2]);
      return prediction;
    }
    const Point& p = points_[links.relations[0].first];
    const Point& q = points_[links.relations[0].second];
    const Point& r = points_[links.relations[0].opposite];
    const Relation& second = links.relations[1];
    const Relation& third = links.relations[2];
    const Point& p2 = points_[second.first];
    const Point& q2 = points_[second.second];
    const Point& r2 = points_[second.opposite];
    const Point& p3 = points_[third.first];
    const Point& q3 = points_[third.second];
    const Point& r3 = points_[third.opposite];
    // The mean of the parallelograms' ends, of which the first counts twice.
    std::array<std::int32_t, 3> mean;
    for (std::size_t i = 0; i < 3; ++i)
      mean[i] = static_cast<std::int32_t>(2 * (p[i] + q[i] - r[i]) + (p2[i] + q2[i] - r2[i]) +
                                          (p3[i] + q3[i] - r3[i]) + 2) >>
                2;
    prediction.x = mean[0];
    prediction.y = mean[1];
    prediction.z = mean[2];
    const std::int64_t ax = static_cast<std::int32_t>(q[0] - p[0]) >> shift_;
    const std::int64_t ay = static_cast<std::int32_t>(q[1] - p[1]) >> shift_;
    const std::int64_t az = static_cast<std::int32_t>(q[2] - p[2]) >> shift_;
    const std::int64_t bx = static_cast<std::int32_t>(r[0] - p[0]) >> shift_;
    const std::int64_t by = static_cast<std::int32_t>(r[1] - p[1]) >> shift_;
    const std::int64_t bz = static_cast<std::int32_t>(r[2] - p[2]) >> shift_;
    const std::int64_t nx = wrapped_difference(ay * bz, az * by);
    const std::int64_t ny = wrapped_difference(az * bx, ax * bz);
    const std::int64_t nz = wrapped_difference(ax * by, ay * bx);
    const int excess = excess_bits(nx, ny, nz, kNormalBits);
    prediction.x_normal = nx >> excess;
    prediction.y_normal = ny >> excess;
    prediction.z_normal = nz >> excess;
    const std::int64_t x_size = std::abs(prediction.x_normal);
    const std::int64_t y_size = std::abs(prediction.y_normal);
    prediction.steepest = y_size > x_size ? 1 : 0;
    if (std::abs(prediction.z_normal) > std::max(x_size, y_size)) prediction.steepest = 2;
    return prediction;
  }

  // Where the plane is at the given distances from the predicted point.
  static std::int32_t height(const Prediction& prediction, std::int32_t first, std::int32_t second) {
    const auto normal =
        rotated(prediction.x_normal, prediction.y_normal, prediction.z_normal, prediction.steepest);
    if (normal.last == 0) return 0;
    const std::int64_t rise = normal.first * first + normal.second * second;
    return static_cast<std::int32_t>(rounded_quotient(normal.last < 0 ? rise : -rise, std::abs(normal.last)));
  }

  FacePrediction predict_on_face(const Prediction& prediction, std::uint32_t face) const;

 private:
  LongVector direction_of(const LongVector& gradient) const {
    LongVector direction{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) direction[i] += basis_.metric[i][j] * gradient[j];
    return direction;
  }

  const Basis& basis_;
  std::span<const VertexLinks> links_;
  std::span<const std::uint8_t> kinds_;
  bool is_cube_;
  std::uint32_t one_;
  int shift_;
  Buffer<Point> points_;
  std::vector<std::uint8_t> faces_;
};

std::int64_t dot(const LongVector& a, const LongVector& b) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum = wrapped_difference(sum, wrapped_product(-a[i], b[i]));
  return sum;
}

// The shortest way within the plane is along s * direction(face) + t * direction(plane), where direction()
// makes the vector of a gradient.
FacePrediction Predictor::predict_on_face(const Prediction& prediction, std::uint32_t face) const {
  Vector end{prediction.x, prediction.y, prediction.z};
  Coordinates start = weights_of(end);
  LongVector gradient{};
  for (std::size_t i = 0; i < 3; ++i)
    gradient[i] = face < 3 ? basis_.to_weights[face][i]
                           : -(basis_.to_weights[0][i] + basis_.to_weights[1][i] + basis_.to_weights[2][i]);
  const int excess =
      excess_bits(prediction.x_normal, prediction.y_normal, prediction.z_normal, kFaceNormalBits);
  const LongVector normal{prediction.x_normal >> excess, prediction.y_normal >> excess,
                          prediction.z_normal >> excess};
  const LongVector face_way = direction_of(gradient);
  const LongVector plane_way = direction_of(normal);
  const std::int64_t a = dot(gradient, face_way);
  const std::int64_t b = dot(gradient, plane_way);
  const std::int64_t c = dot(normal, plane_way);
  const std::int64_t area = wrapped_difference(wrapped_product(a, c), wrapped_product(b, b));
  const auto distance = static_cast<std::int32_t>(start[face]);
  if (area > 0) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t back =
          wrapped_difference(wrapped_product(plane_way[i], b), wrapped_product(face_way[i], c));
      // Two bits less, so that rounding cannot overflow.
      const std::int64_t move = rounded_quotient(wrapped_product(back, distance) >> 2, (area >> 2) + 1);
      end[i] = wrapped_sum(end[i], static_cast<std::int32_t>(move));
    }
    start = weights_of(end);
  }
  FacePrediction result;
  for (std::size_t i = 0, k = 0; i < 4; ++i)
    if (i != face) result.free[k++] = i;
  result.point = start;
  // The gradient of the plane against the weights.
  std::array<std::int64_t, 4> slopes{};
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 3; ++i) slopes[j] += normal[i] * basis_.from_weights[i][j];
  LongVector line{};
  for (std::size_t k = 0; k < 3; ++k)
    line[k] = slopes[result.free[(k + 1) % 3]] - slopes[result.free[(k + 2) % 3]];
  std::size_t first = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(line[k]) > std::abs(line[first])) first = k;
  result.first = result.free[first];
  result.second = result.free[(first + 1) % 3];
  if (line[first] != 0) {
    result.slope_numerator = line[first] < 0 ? -line[(first + 1) % 3] : line[(first + 1) % 3];
    result.slope_denominator = std::abs(line[first]);
  }
  return result;
}

std::int32_t face_height(const FacePrediction& face, std::int32_t along) {
  return static_cast<std::int32_t>(rounded_quotient(face.slope_numerator * along, face.slope_denominator));
}

}  // namespace

void encode_positions(BitEncoder& face_bits, FaceModel& faces, ValueEncoder& values, const Basis& basis,
                      const Links& links, const CodedNode& node, const CodedPart& part) {
  const auto count = static_cast<std::uint32_t>(part.positions.size());
  Predictor predictor(basis, links, node, count);
  struct Along {
    std::uint32_t context;
    std::uint32_t value;
  };
  std::vector<Along> along;
  std::vector<std::uint32_t> across;
  std::vector<Along> face_along;
  std::vector<std::uint32_t> face_across;
  for (std::uint32_t v = 0; v < count; ++v) {
    const Coordinates& weights = part.positions[v];
    std::uint32_t face = kNoFace;
    if (predictor.may_be_on_face(v)) {
      face = Predictor::face_of(weights);
      faces.put(face_bits, predictor.neighbor_faces(v), face);
      predictor.set_face(v, face);
    }
    const Prediction prediction = predictor.predict(v);
    const Vector point = predictor.point_of(weights);
    predictor.set_point(v, point);
    if (face == kNoFace) {
      const auto miss =
          rotated(wrapped_difference(point[0], prediction.x), wrapped_difference(point[1], prediction.y),
                  wrapped_difference(point[2], prediction.z), prediction.steepest);
      along.push_back({kAlong + relations_of(links.kinds[v]), to_unsigned(miss.first)});
      along.push_back({kAlong + relations_of(links.kinds[v]), to_unsigned(miss.second)});
      across.push_back(
          to_unsigned(wrapped_difference(miss.last, Predictor::height(prediction, miss.first, miss.second))));
    } else {
      const FacePrediction on_face = predictor.predict_on_face(prediction, face);
      const auto first = static_cast<std::int32_t>(weights[on_face.first] - on_face.point[on_face.first]);
      const auto second = static_cast<std::int32_t>(weights[on_face.second] - on_face.point[on_face.second]);
      face_along.push_back({kFaceAlong + (relations_of(links.kinds[v]) > 0 ? 1U : 0U), to_unsigned(first)});
      face_across.push_back(to_unsigned(wrapped_difference(second, face_height(on_face, first))));
    }
  }
  for (const Along& a : along) values.put(a.context, a.value);
  values.end_batch();
  for (std::size_t i = 0; i < across.size(); ++i)
    values.put(across_context(along[2 * i].value, along[2 * i + 1].value), across[i]);
  values.end_batch();
  for (const Along& a : face_along) values.put(a.context, a.value);
  values.end_batch();
  for (std::size_t i = 0; i < face_across.size(); ++i)
    values.put(face_across_context(face_along[i].value), face_across[i]);
  values.end_batch();
}

void decode_positions(BitDecoder& face_bits, FaceModel& faces, ValueDecoder& values, const Basis& basis,
                      const Links& links, const CodedNode& node, CodedPart& part) {
  const auto count = static_cast<std::uint32_t>(part.positions.size());
  Predictor predictor(basis, links, node, count);
  Buffer<std::uint8_t> face_of(count);
  Buffer<std::uint8_t> contexts(count);
  Buffer<std::uint8_t> face_contexts(count);
  std::size_t inner_count = 0;
  std::size_t face_count = 0;
  for (std::uint32_t v = 0; v < count; ++v) {
    std::uint32_t face = kNoFace;
    if (predictor.may_be_on_face(v)) {
      face = std::min(faces.get(face_bits, predictor.neighbor_faces(v)), kNoFace);
      predictor.set_face(v, face);
    }
    face_of[v] = static_cast<std::uint8_t>(face);
    if (face == kNoFace)
      contexts[inner_count++] = static_cast<std::uint8_t>(kAlong + relations_of(links.kinds[v]));
    else
      face_contexts[face_count++] =
          static_cast<std::uint8_t>(kFaceAlong + (relations_of(links.kinds[v]) > 0 ? 1 : 0));
  }
  Buffer<std::uint32_t> along(2 * inner_count);
  Buffer<std::uint32_t> across(inner_count);
  Buffer<std::uint32_t> face_along(face_count);
  Buffer<std::uint32_t> face_across(face_count);
  values.get_batch(along.all(), [&](std::size_t i) { return contexts[i / 2]; });
  values.get_batch(across.all(),
                   [&](std::size_t i) { return across_context(along[2 * i], along[2 * i + 1]); });
  values.get_batch(face_along.all(), [&](std::size_t i) { return face_contexts[i]; });
  values.get_batch(face_across.all(), [&](std::size_t i) { return face_across_context(face_along[i]); });
  std::size_t next = 0;
  std::size_t next_face = 0;
  const std::uint32_t one = std::uint32_t{1} << (node.position_bits & 31);
  for (std::uint32_t v = 0; v < count; ++v) {
    const Prediction prediction = predictor.predict(v);
    Coordinates& weights = part.positions[v];
    if (face_of[v] == kNoFace) {
      const std::int32_t first = to_signed(along[2 * next]);
      const std::int32_t second = to_signed(along[2 * next + 1]);
      const std::int32_t last =
          wrapped_sum(to_signed(across[next]), Predictor::height(prediction, first, second));
      const auto miss = unrotated(first, second, last, prediction.steepest);
      const Vector point{wrapped_sum(prediction.x, miss.first), wrapped_sum(prediction.y, miss.second),
                         wrapped_sum(prediction.z, miss.last)};
      ++next;
      weights = predictor.weights_of(point);
      predictor.set_point(v, point);
    } else {
      const FacePrediction on_face = predictor.predict_on_face(prediction, face_of[v]);
      const std::int32_t first = to_signed(face_along[next_face]);
      const std::int32_t second = wrapped_sum(to_signed(face_across[next_face]), face_height(on_face, first));
      ++next_face;
      weights = {};
      weights[on_face.first] = on_face.point[on_face.first] + static_cast<std::uint32_t>(first);
      weights[on_face.second] = on_face.point[on_face.second] + static_cast<std::uint32_t>(second);
      const std::size_t third =
          on_face.free[0] + on_face.free[1] + on_face.free[2] - on_face.first - on_face.second;
      weights[third] = one - weights[on_face.first] - weights[on_face.second];
      predictor.set_point(v, predictor.point_of(weights));
    }
  }
}

}  // namespace colossus::codec::predict
