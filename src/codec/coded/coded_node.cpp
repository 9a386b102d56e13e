#include "codec/coded/coded_node.hpp"

namespace colossus::codec::coded {

std::size_t memory_bytes(const CodedNode& node) {
  std::size_t bytes = sizeof(node);
  for (const CodedPart& part : node.parts)
    bytes += sizeof(part) + part.positions.size() * sizeof(Coordinates) +
             part.normals.size() * sizeof(OctahedralNormal) + part.colors.size() * sizeof(mesh::Color) +
             part.parents.size() * sizeof(std::uint32_t) + part.triangles.size() * sizeof(mesh::Triangle);
  return bytes;
}

}  // namespace colossus::codec::coded
