#include "codec/node_codec.hpp"

#include <algorithm>
#include <limits>

#include "codec/coded/lattice_node.hpp"
#include "codec/coded/renumber.hpp"
#include "codec/coded/weights.hpp"

namespace colossus::codec {
namespace {

using core::Defect;

constexpr std::int32_t kLeastCoordinate = -(std::int32_t{1} << 30);

std::optional<Defect> check_position_bits(const coded::CodedNode& node) {
  if (node.position_bits < coded::kMinPositionBits || node.position_bits > coded::kMaxPositionBits)
    return Defect{"position bits out of range", 2};
  return std::nullopt;
}

// Of offset and bits; so equal meshes are equal nodes.
std::optional<Defect> check_lattice(const coded::CodedNode& node) {
  const std::vector<coded::Coordinates>& positions = node.parts[0].positions;
  coded::Coordinates least{};
  coded::Coordinates greatest{};
  if (!positions.empty()) least = positions.front();
  for (const coded::Coordinates& p : positions)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], p[axis]);
      greatest[axis] = std::max(greatest[axis], p[axis]);
    }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (std::int64_t{node.offset[static_cast<int>(axis)]} + greatest[axis] >
        std::numeric_limits<std::int32_t>::max())
      return Defect{"a coordinate is out of range", 0};
  if (coded::width_of(positions) != node.position_bits)
    return Defect{"the position bits are not those of the widest axis", 2};
  if (least != coded::Coordinates{} || (positions.empty() && node.offset != geometry::Point{}))
    return Defect{"the offset is not the least coordinate", 0};
  if (std::min({node.offset.x, node.offset.y, node.offset.z}) < kLeastCoordinate)
    return Defect{"the offset is out of range", 0};
  return std::nullopt;
}

void check_encodable(const coded::CodedNode& node) {
  for (const coded::CodedPart& part : node.parts) {
    const std::size_t n = part.positions.size();
    COLOSSUS_CHECK(n <= std::numeric_limits<std::uint32_t>::max(), "{} vertices", n);
    COLOSSUS_CHECK(part.normals.size() == (node.has_normals ? n : 0), "{} normals", part.normals.size());
    COLOSSUS_CHECK(part.colors.size() == (node.has_colors ? n : 0), "{} colours", part.colors.size());
    COLOSSUS_CHECK(part.parents.size() == (node.has_parents ? n : 0), "{} parents", part.parents.size());
  }
  COLOSSUS_CHECK(!node.is_on_lattice() || node.parts.size() == 1, "{} parts", node.parts.size());
  const std::optional<Defect> defect = node.is_on_lattice() ? check_lattice(node) : check_position_bits(node);
  COLOSSUS_CHECK(!defect, "{}", defect->message);
}

// Weights sum to 2^bits already but for overflow.
std::optional<Defect> check_weights(const std::vector<coded::Weights>& weights, int position_bits) {
  const std::uint32_t sum = std::uint32_t{1} << position_bits;
  // Bits that no number up to the sum has, and those in which a total differs; no branch for each.
  std::uint32_t wrong = 0;
  for (const coded::Weights& w : weights) {
    wrong |= (w[0] | w[1] | w[2] | w[3]) & ~(2 * sum - 1);
    wrong |= (w[0] + w[1] + w[2] + w[3]) ^ sum;
  }
  if (wrong != 0) return Defect{"barycentric weights do not sum to what they should", 0};
  return std::nullopt;
}

}  // namespace

void put_in_order(coded::CodedPart& part, const Codec& codec) {
  codec.order(part.triangles, part.positions.size());
  const std::vector<std::uint32_t> order =
      coded::renumber_by_first_use(part.triangles, part.positions.size());
  coded::permute(part.positions, order);
  coded::permute(part.normals, order);
  coded::permute(part.colors, order);
  coded::permute(part.parents, order);
}

Payload encode(const coded::CodedNode& node, const Codec& codec) {
  check_encodable(node);
  return to_payload(node, codec);
}

core::Result<coded::CodedNode> decode_with_weights(std::span<const std::byte> bytes, const NodeCounts& most) {
  auto decoded = from_payload(bytes, most);
  if (!decoded) return decoded;
  const coded::CodedNode& node = decoded.value();
  if (node.is_on_lattice()) return Defect{"expected weights for positions, found some on the lattice", 3};
  if (node.has_parents) return Defect{"expected weights for positions, found vertices with parents", 3};
  if (auto defect = check_position_bits(node)) return *std::move(defect);
  for (const coded::CodedPart& part : node.parts) {
    if (auto defect = check_weights(part.positions, node.position_bits)) return *std::move(defect);
    if (coded::used_vertices(part.triangles, part.positions.size()) != part.positions.size())
      return Defect{"a vertex is used by no triangle", 0};
  }
  return decoded;
}

core::Result<coded::CodedNode> decode_on_lattice(std::span<const std::byte> bytes, const NodeCounts& most) {
  auto decoded = from_payload(bytes, most);
  if (!decoded) return decoded;
  const coded::CodedNode& node = decoded.value();
  if (!node.is_on_lattice()) return Defect{"expected positions on the lattice, found weights", 3};
  if (auto defect = check_lattice(node)) return *std::move(defect);
  const coded::CodedPart& part = node.parts[0];
  if (coded::used_vertices(part.triangles, part.positions.size()) > part.positions.size())
    return Defect{"vertices are not in order of first use", 0};
  return decoded;
}

}  // namespace colossus::codec
