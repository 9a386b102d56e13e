// Numbers of parent vertices: that of a neighbour that comes before, mostly, or one that is near it.
#pragma once

#include "codec/predict/basis.hpp"
#include "codec/predict/traversal.hpp"
#include "codec/predict/values.hpp"

namespace colossus::codec::predict {

inline constexpr std::size_t kParentContexts = 3;

void encode_parents(ValueEncoder& values, const Links& links, const coded::CodedPart& part);
void decode_parents(ValueDecoder& values, const Links& links, coded::CodedPart& part);

}  // namespace colossus::codec::predict
