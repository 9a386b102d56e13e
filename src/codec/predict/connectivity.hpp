// Triangles as symbols of the traversal, each coded in the context of what its gate looks like.
#pragma once

#include "codec/coded_node.hpp"
#include "codec/predict/bit_coder.hpp"
#include "codec/predict/traversal.hpp"

namespace colossus::codec::predict {

class SymbolModel {
 public:
  void put(BitEncoder& encoder, const Situation& at, const Step& step, std::uint32_t known);
  Step get(BitDecoder& decoder, const Situation& at, std::uint32_t known);
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
  static constexpr std::uint32_t kValencesB = 10;
  Models& models(const Situation& at);

  std::array<Models, std::size_t{kValencesB} * kValencesA * 16> models_;
  BitModel is_last_;
  std::array<BitModel, 4> is_seed_new_;
};

// The order of triangles that encode_connectivity() wants. Linear.
void order_by_traversal(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count);

// What the traversal tells of the vertices. Triangles must be as order_by_traversal() leaves them.
std::vector<VertexLinks> encode_connectivity(BitEncoder& encoder, SymbolModel& model, const CodedPart& part);

// Fills the triangles; none when the symbols make no sense.
std::optional<std::vector<VertexLinks>> decode_connectivity(BitDecoder& decoder, SymbolModel& model,
                                                            CodedPart& part);

}  // namespace colossus::codec::predict
