// Arbitrary bytes as the payload of a node on the lattice, under a checksum that is made right first: what
// decodes keeps what decode_on_lattice() promises, and in any codec's order it survives encoding and decoding
// by that codec.
#include <cstdint>
#include <cstdlib>

#include "codec/coded/lattice_node.hpp"
#include "codec/node_codec.hpp"
#include "core/hash.hpp"

namespace {

using namespace colossus;

void expect(bool condition) {
  if (!condition) std::abort();
}

void expect_valid(const codec::coded::CodedNode& node) {
  const codec::coded::CodedPart& part = node.parts[0];
  const std::size_t count = part.positions.size();
  for (const geometry::Point& p : lattice_positions(node))
    for (int axis = 0; axis < 3; ++axis) expect(p[axis] >= -geometry::kRootSide);
  expect(part.normals.size() == (node.has_normals ? count : 0));
  expect(part.colors.size() == (node.has_colors ? count : 0));
  expect(part.parents.size() == (node.has_parents ? count : 0));
  std::uint32_t next = 0;
  for (const mesh::Triangle& t : part.triangles)
    for (const std::uint32_t v : t) {
      expect(v < count && v <= next);
      next += v == next ? 1 : 0;
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
  auto decoded = codec::decode_on_lattice(sealed, kMost);
  if (!decoded) return 0;
  codec::coded::CodedNode& node = decoded.value();
  expect_valid(node);
  for (const codec::Codec& codec : codec::codecs()) {
    codec::put_in_order(node.parts[0], codec);
    const auto again = codec::decode_on_lattice(codec::encode(node, codec).bytes, kMost);
    expect(again.ok() && again.value() == node);
  }
  return 0;
}
