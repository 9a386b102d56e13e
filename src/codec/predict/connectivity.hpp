// Triangles as symbols of the traversal, each coded in the context of what its gate looks like.
#pragma once

#include <bit>

#include "codec/coded_node.hpp"
#include "codec/predict/bit_coder.hpp"
#include "codec/predict/traversal.hpp"

namespace colossus::codec::predict {

class SymbolModel {
 public:
  void put(BitEncoder& encoder, const Situation& at, const Step& step, std::uint32_t known);
  Step get(BitDecoder& decoder, const Situation& at, std::uint32_t known) {
    if (at.can_be_last && decoder.get(is_last_)) return {Symbol::kLast, 0};
    Models& m = models(at);
    if (!decoder.get(m.is_new)) return {Symbol::kNew, 0};
    if (at.can_be_right && !decoder.get(m.is_right)) return {Symbol::kRight, 0};
    if (at.can_be_left && !decoder.get(m.is_left)) return {Symbol::kLeft, 0};
    if (!decoder.get(m.is_border)) return {Symbol::kBorder, 0};
    return {Symbol::kKnown, decoder.get_bits(std::bit_width(known))};
  }
  void put_seed(BitEncoder& encoder, const std::array<std::uint32_t, 3>& seed, std::uint32_t known);
  std::array<std::uint32_t, 3> get_seed(BitDecoder& decoder, std::uint32_t known);

 private:
  struct Models {
    BitModel is_new;
    BitModel is_right;
    BitModel is_left;
    BitModel is_border;
  };
  static constexpr std::uint32_t kValencesA = 7;
  static constexpr std::uint32_t kValencesB = kMostValence + 1;
  static constexpr std::uint32_t kLatest = 3;  // new, right, and all others

  Models& models(const Situation& at) {
    const std::uint32_t a = std::min<std::uint32_t>(at.valence_a, kValencesA - 1);
    const std::uint32_t latest = std::min(static_cast<std::uint32_t>(at.latest), kLatest - 1);
    const std::uint32_t sides = (at.can_be_left ? 1U : 0U) + (at.can_be_right ? 2U : 0U);
    return models_[((at.valence_b * kValencesA + a) * kLatest + latest) * 4 + sides];
  }

  std::array<Models, std::size_t{kValencesB} * kValencesA * kLatest * 4> models_;
  BitModel is_last_;
  std::array<BitModel, 3> is_seed_new_;
};

// The order of triangles that encode_connectivity() wants. Linear.
void order_by_traversal(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count);

// Triangles must be as order_by_traversal() leaves them. Fills the links, one for each vertex.
void encode_connectivity(BitEncoder& encoder, SymbolModel& model, const CodedPart& part,
                         std::span<VertexLinks> links);

// Fills the triangles and the links; false when the symbols make no sense.
bool decode_connectivity(BitDecoder& decoder, SymbolModel& model, CodedPart& part,
                         std::span<VertexLinks> links);

}  // namespace colossus::codec::predict
