// Arbitrary bytes as the sections of a node in the paper's codec, with no checksum in the way: what decodes
// has its indices in range, and survives encoding and decoding as it is and in the codec's order.
//
// The input begins with flags, position bits, and the number of parts; each part with its numbers of vertices
// and triangles, of a byte each; then each section but the last with its size, of two bytes.
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "codec/paper/paper_codec.hpp"
#include "codec/paper/strips.hpp"

namespace {

using namespace colossus;

void expect(bool condition) {
  if (!condition) std::abort();
}

codec::coded::CodedNode blank_node(core::ByteReader& reader) {
  codec::coded::CodedNode node;
  const auto flags = reader.get<std::uint8_t>();
  if ((flags & 1) != 0) node.position_kind = codec::coded::PositionKind::kLattice;
  node.has_normals = (flags & 2) != 0;
  node.has_colors = (flags & 4) != 0;
  node.has_parents = (flags & 8) != 0;
  node.position_bits = reader.get<std::uint8_t>() % 33;
  node.parts.resize(node.is_on_lattice() ? 1 : reader.get<std::uint8_t>() % 9);
  for (codec::coded::CodedPart& part : node.parts) {
    const std::size_t n = reader.get<std::uint8_t>();
    part.positions.resize(n);
    part.normals.resize(node.has_normals ? n : 0);
    part.colors.resize(node.has_colors ? n : 0);
    part.parents.resize(node.has_parents ? n : 0);
    part.triangles.resize(reader.get<std::uint8_t>());
  }
  return node;
}

codec::coded::SectionViews views(const codec::coded::Sections& sections) {
  codec::coded::SectionViews result;
  std::copy(sections.begin(), sections.end(), result.begin());
  return result;
}

void expect_round_trip(const codec::coded::CodedNode& node) {
  const codec::coded::Sections sections = codec::paper::encode_paper(node);
  codec::coded::CodedNode again = node;
  for (codec::coded::CodedPart& part : again.parts) {
    std::fill(part.positions.begin(), part.positions.end(), codec::coded::Coordinates{});
    std::fill(part.normals.begin(), part.normals.end(), codec::coded::OctahedralNormal{});
    std::fill(part.colors.begin(), part.colors.end(), mesh::Color{});
    std::fill(part.parents.begin(), part.parents.end(), 0);
    std::fill(part.triangles.begin(), part.triangles.end(), mesh::Triangle{});
  }
  expect(!codec::paper::decode_paper(views(sections), again));
  for (std::size_t i = 0; i < node.parts.size(); ++i) {
    const codec::coded::CodedPart& a = node.parts[i];
    const codec::coded::CodedPart& b = again.parts[i];
    expect(a.positions == b.positions && a.normals == b.normals && a.colors == b.colors);
    expect(a.parents == b.parents && a.triangles == b.triangles);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  core::ByteReader reader(std::as_bytes(std::span(data, size)));
  codec::coded::CodedNode node = blank_node(reader);
  codec::coded::SectionViews sections;
  for (std::size_t i = 0; i < sections.size(); ++i)
    sections[i] =
        reader.get_bytes(i + 1 < sections.size() ? reader.get<std::uint16_t>() : reader.remaining());
  if (reader.failed() || codec::paper::decode_paper(sections, node)) return 0;
  for (const codec::coded::CodedPart& part : node.parts)
    for (const mesh::Triangle& t : part.triangles)
      for (const std::uint32_t v : t) expect(v < part.positions.size());
  expect_round_trip(node);
  for (codec::coded::CodedPart& part : node.parts)
    codec::paper::order_in_strips(part.triangles, part.positions.size());
  expect_round_trip(node);
  return 0;
}
