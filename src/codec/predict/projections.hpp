// Where in the octahedron's square the predicted normals lie. The square's sides have 255 cells. Around its
// lower pole it is folded over, so that a prediction near its border has neighbours on all sides.
#pragma once

#include <cstdint>

#include "codec/predict/buffer.hpp"
#include "codec/predict/face_sums.hpp"

namespace colossus::codec::predict {

// Numbers of a place: fixed point, and half a cell more.
inline constexpr int kPoint = 24;
inline constexpr std::uint32_t kHalf = 1U << (kPoint - 1);
struct Projections {
  // The lowest bit of u is fine enough to be given away: it is set where the square is folded.
  Buffer<std::uint32_t> u;
  Buffer<std::uint32_t> v;
};

// 0 to 255.
constexpr std::int32_t nearest_cell(std::uint32_t place) {
  return static_cast<std::int32_t>(place >> kPoint);
}
// The opposite where the prediction is below the cell's middle; for any 32 bits.
constexpr std::uint32_t with_sign_of(std::uint32_t place, std::uint32_t value) {
  const std::uint32_t mask = (place >> (kPoint - 1) & 1) - 1;
  return (value ^ mask) - mask;
}
// All bits set where the square is folded, since a condition would keep compilers from doing several at a
// time.
constexpr std::int32_t fold_mask(std::uint32_t u) { return -static_cast<std::int32_t>(u & 1); }

// One for each sum. Of no direction is the square's middle.
Projections project(const Buffer<FaceSum>& sums);

}  // namespace colossus::codec::predict
