#include "codec/predict/positions.hpp"

#include "codec/predict/buffer.hpp"
#include "codec/predict/point_predictor.hpp"

namespace colossus::codec::predict {
namespace {

// Contexts of values.
constexpr std::uint32_t kAlong = 0;        // by the number of parallelograms
constexpr std::uint32_t kAcross = 4;       // by the size of the two before
constexpr std::uint32_t kFaceAlong = 8;    // by whether there is a parallelogram
constexpr std::uint32_t kFaceAcross = 10;  // by the size of the one before

// As to_unsigned() makes numbers, those of a magnitude begin here.
constexpr std::uint32_t least_of(std::uint32_t magnitude) { return 2 * magnitude - 1; }

std::uint32_t across_context(std::uint32_t first, std::uint32_t second) {
  return kAcross + class_of(std::max(first, second), least_of(4), least_of(12), least_of(40));
}
std::uint32_t face_across_context(std::uint32_t along) {
  return kFaceAcross + class_of(along, least_of(4), least_of(24));
}

// The only weight that is 0, or kNoFace.
std::uint32_t face_of(const coded::Coordinates& weights) {
  std::uint32_t face = kNoFace;
  for (std::uint32_t i = 0; i < 4; ++i) {
    if (weights[i] != 0) continue;
    if (face != kNoFace) return kNoFace;
    face = i;
  }
  return face;
}

std::uint32_t zigzag(std::uint32_t value) { return to_unsigned(static_cast<std::int32_t>(value)); }

void decode_faces(entropy::RangeDecoder& bits, FaceModel& faces, PointPredictor& predictor,
                  std::uint32_t count) {
  // A list first: a branch for each vertex would be a guess.
  Buffer<std::uint32_t> border(count);
  std::size_t border_count = 0;
  for (std::uint32_t v = 0; v < count; ++v) {
    border[border_count] = v;
    border_count += predictor.may_be_on_face(v) ? 1 : 0;
  }
  for (const std::uint32_t v : border.first(border_count))
    predictor.set_face(v, std::min(faces.get(bits, predictor.neighbor_faces(v)), kNoFace));
}

// Of the vertices that are on no face, and of those that are, in order.
struct Residuals {
  Buffer<std::uint32_t> along;  // two each
  Buffer<std::uint32_t> across;
  Buffer<std::uint32_t> face_along;
  Buffer<std::uint32_t> face_across;
};

Residuals decode_residuals(ValueDecoder& values, const PointPredictor& predictor,
                           std::span<const std::uint8_t> kinds) {
  Buffer<std::uint8_t> contexts(kinds.size());
  Buffer<std::uint8_t> face_contexts(kinds.size());
  // Without a branch: each vertex is written to both lists, and the next one takes its place in one of them.
  std::size_t inner_count = 0;
  for (std::uint32_t v = 0; v < kinds.size(); ++v) {
    const std::uint32_t relations = relations_of(kinds[v]);
    contexts[inner_count] = static_cast<std::uint8_t>(kAlong + relations);
    face_contexts[v - inner_count] = static_cast<std::uint8_t>(kFaceAlong + (relations > 0 ? 1 : 0));
    inner_count += predictor.is_on_face(v) ? 0 : 1;
  }
  const std::size_t face_count = kinds.size() - inner_count;
  Buffer<std::uint32_t> along(2 * inner_count);
  Buffer<std::uint32_t> across(inner_count);
  Buffer<std::uint32_t> face_along(face_count);
  Buffer<std::uint32_t> face_across(face_count);
  values.get_batch(along.all(), [&](std::size_t i) { return contexts[i / 2]; });
  values.get_batch(across.all(),
                   [&](std::size_t i) { return across_context(along[2 * i], along[2 * i + 1]); });
  values.get_batch(face_along.all(), [&](std::size_t i) { return face_contexts[i]; });
  values.get_batch(face_across.all(), [&](std::size_t i) { return face_across_context(face_along[i]); });
  for (auto* const list : {&along, &across, &face_along, &face_across})
    for (std::uint32_t& value : list->all()) value = static_cast<std::uint32_t>(to_signed(value));
  return {std::move(along), std::move(across), std::move(face_along), std::move(face_across)};
}

template <bool kIsNarrow>
void decode_points(PointPredictor& predictor, const Residuals& residuals, std::uint32_t count) {
  std::size_t inner = 0;
  std::size_t face = 0;
  for (std::uint32_t v = 0; v < count; ++v) {
    const Parallelograms from = predictor.parallelograms(v);
    if (!predictor.is_on_face(v)) {
      const Residual residual{residuals.along[2 * inner], residuals.along[2 * inner + 1],
                              residuals.across[inner]};
      predictor.set_point(
          v, kIsNarrow ? predictor.narrow_point_at(from, residual) : predictor.point_at(from, residual));
      ++inner;
    } else {
      const LongVector normal =
          kIsNarrow ? PointPredictor::narrow_normal_of(from) : predictor.normal_of(from);
      const FacePrediction on_face = predictor.predict_on_face(from.end, normal, predictor.face_of(v));
      predictor.set_point(v, on_face.point_at({residuals.face_along[face], residuals.face_across[face]}));
      ++face;
    }
  }
}

}  // namespace

void encode_positions(entropy::RangeEncoder& face_bits, FaceModel& faces, ValueEncoder& values,
                      const Basis& basis, const Links& links, const coded::CodedNode& node,
                      const coded::CodedPart& part) {
  const auto count = static_cast<std::uint32_t>(part.positions.size());
  PointPredictor predictor(basis, links, node, count);
  struct Along {
    std::uint32_t context;
    std::uint32_t value;
  };
  std::vector<Along> along;
  std::vector<std::uint32_t> across;
  std::vector<Along> face_along;
  std::vector<std::uint32_t> face_across;
  for (std::uint32_t v = 0; v < count; ++v) {
    const coded::Coordinates& weights = part.positions[v];
    const std::uint32_t relations = relations_of(links.kinds[v]);
    std::uint32_t face = kNoFace;
    if (predictor.may_be_on_face(v)) {
      face = face_of(weights);
      faces.put(face_bits, predictor.neighbor_faces(v), face);
      predictor.set_face(v, face);
    }
    const Parallelograms from = predictor.parallelograms(v);
    const Lanes point = predictor.point_of(weights);
    predictor.set_point(v, point);
    if (face == kNoFace) {
      const Residual residual = predictor.residual_of(from, point);
      along.push_back({kAlong + relations, zigzag(residual.first)});
      along.push_back({kAlong + relations, zigzag(residual.second)});
      across.push_back(zigzag(residual.across));
    } else {
      const FaceResidual residual =
          predictor.predict_on_face(from.end, predictor.normal_of(from), face).residual_of(weights);
      face_along.push_back({kFaceAlong + (relations > 0 ? 1U : 0U), zigzag(residual.first)});
      face_across.push_back(zigzag(residual.across));
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

void decode_positions(entropy::RangeDecoder& face_bits, FaceModel& faces, ValueDecoder& values,
                      const Basis& basis, const Links& links, const coded::CodedNode& node,
                      coded::CodedPart& part) {
  const auto count = static_cast<std::uint32_t>(part.positions.size());
  PointPredictor predictor(basis, links, node, count);
  decode_faces(face_bits, faces, predictor, count);
  const Residuals residuals = decode_residuals(values, predictor, links.kinds);
  // Up to the first point that is not narrow all are right. Only bytes of no sense lead to one.
  if (node.position_bits <= kPlaneBits) {
    decode_points<true>(predictor, residuals, count);
    if (predictor.set_weights(part.positions)) return;
  }
  decode_points<false>(predictor, residuals, count);
  predictor.set_weights(part.positions);
}

}  // namespace colossus::codec::predict
