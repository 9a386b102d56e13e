// A node whose positions lie on the container's lattice, each against the least of each coordinate, with as
// many bits as the widest axis needs.
#pragma once

#include <span>

#include "codec/coded/coded_node.hpp"

namespace colossus::codec::coded {

// With its one part, which is empty.
CodedNode lattice_node();

// Where a vertex of the part lies.
inline geometry::Point lattice_position(const CodedNode& node, std::size_t vertex) {
  const Coordinates& p = node.parts[0].positions[vertex];
  geometry::Point result;
  for (int axis = 0; axis < 3; ++axis)
    result[axis] = static_cast<std::int32_t>(static_cast<std::uint32_t>(node.offset[axis]) +
                                             p[static_cast<std::size_t>(axis)]);
  return result;
}

// Of all vertices.
std::vector<geometry::Point> lattice_positions(const CodedNode& node);

// Sets these, and with them offset and bits.
void set_lattice_positions(CodedNode& node, std::span<const geometry::Point> positions);

// How many bits the widest axis needs.
int width_of(const std::vector<Coordinates>& positions);

}  // namespace colossus::codec::coded
