// One decoded tetrahedron with its vertices welded by position, as an extracted cut has it.
#pragma once

#include <cstdint>
#include <vector>

#include "codec/coded/weights.hpp"

namespace colossus::reader::diamonds {

// Distinct positions of one tetrahedron and the triangles between them. A position that has no zero weight
// lies strictly inside, so no other tetrahedron of the same cut has it.
struct WeldedTetrahedron {
  std::vector<codec::coded::ScaledPosition> positions;
  std::vector<std::uint8_t> zero_weights;  // per position, bit i: the weight of corner i is 0
  std::vector<std::uint32_t> sources;      // per position: its first vertex
  std::vector<mesh::Triangle> triangles;   // of positions; none with two equal ones
};

// Linear.
WeldedTetrahedron weld_positions(const codec::coded::CodedPart& part,
                                 const hierarchy::Tetrahedron& tetrahedron);

}  // namespace colossus::reader::diamonds
