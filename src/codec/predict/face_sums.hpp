// The sum of the face normals around each vertex, by area: of which way the surface looks there.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "codec/coded/coded_node.hpp"
#include "codec/predict/buffer.hpp"

namespace colossus::codec::predict {

// Components in the order z, x, y, which the fast way yields, then the number of triangles or anything.
struct alignas(16) FaceSum {
  std::array<std::int32_t, 4> components;
};

// A component of a sum keeps so many bits when it is used: higher ones of equal shift may be left out before.
inline constexpr int kSumBits = 14;

// One for each vertex. With an `own_weight` above 0 sums are smoothed: so many times the vertex's own, and
// once per triangle those of the two neighbours. Where sums have more than 32 bits, the three components of
// a vertex are shifted down to kSumBits bits.
Buffer<FaceSum> face_sums(int position_bits, const coded::CodedPart& part, std::int32_t own_weight);

// The two ways in which it is done. The narrow one gives nothing where its numbers might not be exact; the
// wide one takes anything, shifts all sums down, and is several times slower.
std::optional<Buffer<FaceSum>> narrow_face_sums(int position_bits, const coded::CodedPart& part,
                                                std::int32_t own_weight);
Buffer<FaceSum> wide_face_sums(int position_bits, const coded::CodedPart& part, std::int32_t own_weight);

}  // namespace colossus::codec::predict
