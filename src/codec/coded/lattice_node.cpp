#include "codec/coded/lattice_node.hpp"

#include <bit>

namespace colossus::codec::coded {

CodedNode lattice_node() {
  CodedNode node;
  node.position_kind = PositionKind::kLattice;
  node.parts.resize(1);
  return node;
}

std::vector<geometry::Point> lattice_positions(const CodedNode& node) {
  std::vector<geometry::Point> positions(node.parts[0].positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) positions[v] = lattice_position(node, v);
  return positions;
}

void set_lattice_positions(CodedNode& node, std::span<const geometry::Point> positions) {
  node.offset = positions.empty() ? geometry::Point{} : positions.front();
  for (const geometry::Point& p : positions)
    for (int axis = 0; axis < 3; ++axis) node.offset[axis] = std::min(node.offset[axis], p[axis]);
  std::vector<Coordinates>& against_offset = node.parts[0].positions;
  against_offset.assign(positions.size(), {});
  for (std::size_t v = 0; v < positions.size(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      against_offset[v][static_cast<std::size_t>(axis)] =
          static_cast<std::uint32_t>(std::int64_t{positions[v][axis]} - node.offset[axis]);
  node.position_bits = width_of(against_offset);
}

int width_of(const std::vector<Coordinates>& positions) {
  std::uint32_t all = 0;  // the widest has the highest bit
  for (const Coordinates& p : positions) all |= p[0] | p[1] | p[2];
  return std::bit_width(all);
}

}  // namespace colossus::codec::coded
