#include "codec/node_codec.hpp"

#include "codec/coded/renumber.hpp"

namespace colossus::codec {
namespace {

using core::Defect;

void check_encodable(const coded::NodeMesh& node) {
  COLOSSUS_CHECK(
      node.position_bits >= coded::kMinPositionBits && node.position_bits <= coded::kMaxPositionBits,
      "{} position bits", node.position_bits);
  for (const coded::QuantizedTetrahedron& part : node.tetrahedra) {
    const std::size_t n = part.weights.size();
    COLOSSUS_CHECK(part.normals.size() == (node.has_normals ? n : 0), "{} normals", part.normals.size());
    COLOSSUS_CHECK(part.colors.size() == (node.has_colors ? n : 0), "{} colours", part.colors.size());
  }
}

// Weights sum to 2^bits already but for overflow.
std::optional<Defect> check_weights(const std::vector<coded::Coordinates>& weights, int position_bits) {
  const std::uint32_t sum = std::uint32_t{1} << position_bits;
  // Bits that no number up to the sum has, and those in which a total differs; no branch for each.
  std::uint32_t wrong = 0;
  for (const coded::Coordinates& w : weights) {
    wrong |= (w[0] | w[1] | w[2] | w[3]) & ~(2 * sum - 1);
    wrong |= (w[0] + w[1] + w[2] + w[3]) ^ sum;
  }
  if (wrong != 0) return Defect{"barycentric weights do not sum to what they should", 0};
  return std::nullopt;
}

core::Result<coded::QuantizedTetrahedron> to_tetrahedron(coded::CodedPart&& part, int position_bits) {
  if (auto defect = check_weights(part.positions, position_bits)) return *std::move(defect);
  if (coded::used_vertices(part.triangles, part.positions.size()) != part.positions.size())
    return Defect{"a vertex is used by no triangle", 0};
  coded::QuantizedTetrahedron result;
  result.place = part.place;
  result.frame = part.frame;
  result.marks.resize(part.positions.size());
  for (std::size_t i = 0; i < result.marks.size(); ++i) result.marks[i] = coded::marks_of(part.positions[i]);
  result.weights = std::move(part.positions);
  result.normals = std::move(part.normals);
  result.colors = std::move(part.colors);
  result.triangles = std::move(part.triangles);
  return result;
}

}  // namespace

void put_in_order(coded::QuantizedTetrahedron& part, const Codec& codec) {
  codec.order(part.triangles, part.weights.size());
  const std::vector<std::uint32_t> order = coded::renumber_by_first_use(part.triangles, part.weights.size());
  coded::permute(part.weights, order);
  coded::permute(part.marks, order);
  coded::permute(part.normals, order);
  coded::permute(part.colors, order);
}

Payload encode(const coded::NodeMesh& node, const Codec& codec) {
  check_encodable(node);
  coded::CodedNode coded;
  coded.position_bits = node.position_bits;
  coded.has_normals = node.has_normals;
  coded.has_colors = node.has_colors;
  for (const coded::QuantizedTetrahedron& part : node.tetrahedra)
    coded.parts.push_back(
        {part.place, part.frame, part.weights, part.normals, part.colors, {}, part.triangles});
  return to_payload(coded, codec);
}

core::Result<coded::NodeMesh> decode(std::span<const std::byte> bytes, const NodeCounts& most) {
  auto coded = from_payload(bytes, most);
  if (!coded) return coded.defect();
  coded::CodedNode& from = coded.value();
  if (from.is_cube || from.has_parents) return Defect{"expected a node of tetrahedra, found one of cubes", 3};
  if (from.position_bits < coded::kMinPositionBits || from.position_bits > coded::kMaxPositionBits)
    return Defect{"position bits out of range", 2};
  coded::NodeMesh node{from.position_bits, from.has_normals, from.has_colors, {}};
  for (coded::CodedPart& part : from.parts) {
    auto tetrahedron = to_tetrahedron(std::move(part), from.position_bits);
    if (!tetrahedron) return tetrahedron.defect();
    node.tetrahedra.push_back(std::move(tetrahedron).value());
  }
  return node;
}

}  // namespace colossus::codec
