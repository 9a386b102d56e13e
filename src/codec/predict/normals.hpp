// Normals, predicted from the decoded geometry: the sum of the face normals around the vertex. Where
// positions are so coarse that this is noise, sums are smoothed over neighbours, and what the neighbours'
// normals missed their predictions by is expected again.
#pragma once

#include "codec/predict/basis.hpp"
#include "codec/predict/traversal.hpp"
#include "codec/predict/values.hpp"

namespace colossus::codec::predict {

// How predictions are made; the encoder tries all.
enum class NormalMode : std::uint8_t { kSum, kSumAndMiss, kSmoothed, kMoreSmoothed };
inline constexpr std::uint8_t kNormalModes = 4;

inline constexpr std::uint32_t kNormalSizes = 6;
inline constexpr std::size_t kNormalContexts = 2 + 2 * kNormalSizes;

// The mode that gives the least misses over all parts.
NormalMode choose_normal_mode(const coded::CodedNode& node, const std::vector<Links>& links);

void encode_normals(ValueEncoder& values, NormalMode mode, const Links& links, const coded::CodedNode& node,
                    const coded::CodedPart& part);
void decode_normals(ValueDecoder& values, NormalMode mode, const Links& links, const coded::CodedNode& node,
                    coded::CodedPart& part);

}  // namespace colossus::codec::predict
