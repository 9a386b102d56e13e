// A codec's decoder on its own: the first bytes choose the codec, old versions behind the present ones, and the
// shape of a node of one or two parts, the rest is cut into its sections. With COLOSSUS_CODEC=<name> in the
// environment it is always that codec. Whatever comes back has the right sizes and indices in range.
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "codec/codec.hpp"

namespace {

using namespace colossus;

void expect(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  core::ByteReader reader(std::as_bytes(std::span(data, size)));
  const auto codecs = codec::codecs();
  const auto old_versions = codec::old_versions();
  static const char* const only = std::getenv("COLOSSUS_CODEC");
  const auto choice = reader.get<std::uint8_t>();
  const std::size_t number = choice % (codecs.size() + old_versions.size());
  const codec::Codec& codec = only != nullptr          ? codec::codec_named(only)
                              : number < codecs.size() ? codecs[number]
                                                       : old_versions[number - codecs.size()];
  const auto flags = reader.get<std::uint8_t>();
  codec::coded::CodedNode node;
  node.has_normals = (flags & 1) != 0;
  node.has_colors = (flags & 2) != 0;
  node.has_parents = (flags & 4) != 0;
  if ((flags & 8) != 0) node.position_kind = codec::coded::PositionKind::kLattice;
  node.position_bits = reader.get<std::uint8_t>() % 33;
  node.parts.resize(node.is_on_lattice() ? 1 : 1 + flags / 128);
  for (codec::coded::CodedPart& part : node.parts) {
    const std::size_t vertices = reader.get<std::uint16_t>() % 128;
    part.positions.resize(vertices);
    part.normals.resize(node.has_normals ? vertices : 0);
    part.colors.resize(node.has_colors ? vertices : 0);
    part.parents.resize(node.has_parents ? vertices : 0);
    part.triangles.resize(reader.get<std::uint16_t>() % 256);
    if (!node.is_on_lattice())
      for (auto& row : part.frame)
        for (auto& entry : row) entry = static_cast<std::int8_t>(reader.get<std::uint8_t>() % 5 - 2);
  }
  codec::coded::SectionViews sections;
  for (auto& section : sections)
    section = reader.get_bytes(std::min<std::uint64_t>(reader.get<std::uint16_t>(), reader.remaining()));
  std::vector<std::size_t> counts;
  for (const codec::coded::CodedPart& part : node.parts) counts.push_back(part.triangles.size());
  if (codec.decode(sections, node)) return 0;
  for (std::size_t i = 0; i < node.parts.size(); ++i) {
    expect(node.parts[i].triangles.size() == counts[i]);
    for (const mesh::Triangle& t : node.parts[i].triangles)
      for (const std::uint32_t v : t) expect(v < node.parts[i].positions.size());
  }
  return 0;
}
