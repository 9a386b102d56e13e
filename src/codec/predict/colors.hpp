// Colours, predicted by the mean of the neighbours that come before; what is left is turned into luma and two
// chromas without loss (YCoCg-R: Malvar, Sullivan and Srinivasan, Lifting-based reversible color
// transformations for image compression, 2008). Opacity stays apart.
#pragma once

#include "codec/predict/basis.hpp"
#include "codec/predict/traversal.hpp"
#include "codec/predict/values.hpp"

namespace colossus::codec::predict {

inline constexpr std::size_t kColorContexts = 2 + 3 + 3 + 1;

// What the first vertex is predicted by: where all is opaque, no opacity need be read. Version 1 of the codec
// had transparent black.
inline constexpr mesh::Color kOpaqueBlack{0, 0, 0, 255};
inline constexpr mesh::Color kTransparentBlack{0, 0, 0, 0};

void encode_colors(ValueEncoder& values, const Links& links, const coded::CodedPart& part);
void decode_colors(ValueDecoder& values, const Links& links, coded::CodedPart& part,
                   const mesh::Color& first);

}  // namespace colossus::codec::predict
