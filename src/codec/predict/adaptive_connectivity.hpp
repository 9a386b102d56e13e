// Connectivity of version 1 of the codec, read only: symbols as bits of one adaptive coder, in the traversal.
#pragma once

#include "codec/coded/coded_node.hpp"
#include "codec/predict/connectivity.hpp"

namespace colossus::codec::predict {

// As ConnectivityDecoder.
class AdaptiveConnectivityDecoder {
 public:
  AdaptiveConnectivityDecoder(std::span<const std::byte> bytes, std::size_t) : bits_(bytes) {}
  bool decode(coded::CodedPart& part, LinkStore& store);
  entropy::RangeDecoder& bits() { return bits_; }
  // Bits have no end.
  bool is_done() const { return true; }

 private:
  friend class AdaptiveSource;
  struct Models {
    entropy::GrowingWindowModel is_new;
    entropy::GrowingWindowModel is_right;
    entropy::GrowingWindowModel is_left;
    entropy::GrowingWindowModel is_border;
  };
  static constexpr std::uint32_t kValencesA = 7;
  static constexpr std::uint32_t kValencesB = 10;
  static constexpr std::uint32_t kLatest = 3;

  entropy::RangeDecoder bits_;
  SeedModel seeds_;
  std::array<Models, std::size_t{kValencesB} * kValencesA * kLatest * 4> models_;
  entropy::GrowingWindowModel is_last_;
};

}  // namespace colossus::codec::predict
