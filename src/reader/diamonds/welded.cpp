#include "reader/diamonds/welded.hpp"

#include "codec/coded/places.hpp"

namespace colossus::reader::diamonds {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

}  // namespace

WeldedTetrahedron weld_positions(const codec::coded::CodedPart& part,
                                 const hierarchy::Tetrahedron& tetrahedron) {
  const std::vector<std::uint32_t> first = codec::coded::first_at_place(part.positions);
  WeldedTetrahedron welded;
  std::vector<std::uint32_t> renumbered(part.positions.size(), kNone);
  for (std::uint32_t i = 0; i < part.positions.size(); ++i) {
    if (first[i] != i) continue;
    renumbered[i] = static_cast<std::uint32_t>(welded.positions.size());
    welded.positions.push_back(codec::coded::scaled_position(part.positions[i], tetrahedron));
    welded.zero_weights.push_back(codec::coded::marks_of(part.positions[i]));
    welded.sources.push_back(i);
  }
  welded.triangles.reserve(part.triangles.size());
  for (const mesh::Triangle& t : part.triangles) {
    const mesh::Triangle w{renumbered[first[t[0]]], renumbered[first[t[1]]], renumbered[first[t[2]]]};
    if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) welded.triangles.push_back(w);
  }
  return welded;
}

}  // namespace colossus::reader::diamonds
