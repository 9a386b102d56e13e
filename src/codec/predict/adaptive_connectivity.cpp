#include "codec/predict/adaptive_connectivity.hpp"

#include <bit>

namespace colossus::codec::predict {

class AdaptiveSource {
 public:
  static constexpr bool kNeedsEnds = false;

  explicit AdaptiveSource(AdaptiveConnectivityDecoder& decoder) : decoder_(decoder) {}
  std::array<std::uint32_t, 3> seed(std::uint32_t known) {
    return decoder_.seeds_.get(decoder_.bits_, known);
  }
  Symbol step(const Situation& at, std::uint32_t) {
    entropy::RangeDecoder& bits = decoder_.bits_;
    if (at.can_be_last() && bits.decode(decoder_.is_last_)) return Symbol::kLast;
    auto& models = models_of(at);
    if (!bits.decode(models.is_new)) return Symbol::kNew;
    if (at.can_be_right() && !bits.decode(models.is_right)) return Symbol::kRight;
    if (at.can_be_left() && !bits.decode(models.is_left)) return Symbol::kLeft;
    return bits.decode(models.is_border) ? Symbol::kKnown : Symbol::kBorder;
  }
  std::uint32_t known_vertex(std::uint32_t known) {
    return decoder_.bits_.decode_bits(std::bit_width(known));
  }
  void opened(std::uint32_t, GateOrigin) {}

 private:
  AdaptiveConnectivityDecoder::Models& models_of(const Situation& at) {
    using Decoder = AdaptiveConnectivityDecoder;
    const std::uint32_t a = std::min(at.valence_a, Decoder::kValencesA - 1);
    const std::uint32_t b = std::min(at.valence_b, Decoder::kValencesB - 1);
    const std::uint32_t sides = (at.can_be_left() ? 1U : 0U) + (at.can_be_right() ? 2U : 0U);
    return decoder_.models_[((b * Decoder::kValencesA + a) * Decoder::kLatest + at.latest) * 4 + sides];
  }

  AdaptiveConnectivityDecoder& decoder_;
};

bool AdaptiveConnectivityDecoder::decode(coded::CodedPart& part, LinkStore& store) {
  AdaptiveSource source(*this);
  return traverse(source, std::span(part.triangles), part.positions.size(), store);
}

}  // namespace colossus::codec::predict
