// Positions, each predicted by the parallelograms that its vertex continues (Touma and Gotsman, Triangle mesh
// compression, 1998; several of them averaged: Isenburg and Alliez, Compressing polygon mesh geometry with
// parallelogram prediction, 2002), in coordinates of Basis. Two departures:
//
// - Of the three coordinates that in which the surface is steepest is coded last, against the plane through
//   the predicted point: only noise across the surface is left.
// - A vertex on the border of a tetrahedron's mesh lies on a face of the tetrahedron, nearly always: then the
//   predicted point is moved within that plane onto the face, and two numbers are left, one along the line
//   in which plane and face meet, and one across.
#pragma once

#include "codec/entropy/bit_models.hpp"
#include "codec/predict/basis.hpp"
#include "codec/predict/traversal.hpp"
#include "codec/predict/values.hpp"

namespace colossus::codec::predict {

// On which single face border vertices lie, if so, in the context of what neighbours lie on.
class FaceModel {
 public:
  void put(entropy::RangeEncoder& encoder, std::uint32_t neighbor_faces, std::uint32_t face) {
    trees_[neighbor_faces].encode(encoder, face);
  }
  std::uint32_t get(entropy::RangeDecoder& decoder, std::uint32_t neighbor_faces) {
    return trees_[neighbor_faces].decode(decoder);
  }

 private:
  std::array<entropy::TreeModel<3>, 16> trees_;
};

inline constexpr std::size_t kPositionContexts = 4 + 4 + 2 + 3;

void encode_positions(entropy::RangeEncoder& face_bits, FaceModel& faces, ValueEncoder& values,
                      const Basis& basis, const Links& links, const coded::CodedNode& node,
                      const coded::CodedPart& part);

void decode_positions(entropy::RangeDecoder& face_bits, FaceModel& faces, ValueDecoder& values,
                      const Basis& basis, const Links& links, const coded::CodedNode& node,
                      coded::CodedPart& part);

}  // namespace colossus::codec::predict
