// Arbitrary bytes as a node's payload, under a checksum that is made right first: what decodes keeps what
// decode_with_weights() promises, and in any codec's order it survives encoding and decoding by that codec.
#include <cstdint>
#include <cstdlib>

#include "codec/coded/weights.hpp"
#include "codec/node_codec.hpp"
#include "core/hash.hpp"

namespace {

using namespace colossus;

void expect(bool condition) {
  if (!condition) std::abort();
}

void expect_valid(const codec::coded::CodedNode& node) {
  expect(node.position_bits >= codec::coded::kMinPositionBits &&
         node.position_bits <= codec::coded::kMaxPositionBits);
  int last_place = -1;
  for (const codec::coded::CodedPart& part : node.parts) {
    expect(int{part.place} > last_place);
    last_place = part.place;
    const std::size_t count = part.positions.size();
    for (const codec::coded::Weights& w : part.positions)
      expect(std::uint64_t{w[0]} + w[1] + w[2] + w[3] == std::uint64_t{1} << node.position_bits);
    expect(part.normals.size() == (node.has_normals ? count : 0));
    expect(part.colors.size() == (node.has_colors ? count : 0));
    for (const mesh::Triangle& t : part.triangles)
      for (const std::uint32_t v : t) expect(v < count);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  core::Bytes sealed(input.begin(), input.end());
  core::ByteWriter checksum;
  checksum.put(core::hash64(input));
  sealed.insert(sealed.end(), checksum.bytes().begin(), checksum.bytes().end());
  constexpr codec::NodeCounts kMost{10000, 10000};
  auto node = codec::decode_with_weights(sealed, kMost);
  if (!node) return 0;
  expect_valid(node.value());
  for (const codec::Codec& codec : codec::codecs()) {
    for (codec::coded::CodedPart& part : node.value().parts) codec::put_in_order(part, codec);
    const auto again = codec::decode_with_weights(codec::encode(node.value(), codec).bytes, kMost);
    expect(again.ok() && again.value() == node.value());
  }
  return 0;
}
