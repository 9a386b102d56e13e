#include "codec/cube_codec.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "codec/coded/renumber.hpp"

namespace colossus::codec {
namespace {

using core::Defect;

constexpr std::int32_t kLeastCoordinate = -(std::int32_t{1} << 30);

std::uint32_t difference(std::int32_t coordinate, std::int32_t offset) {
  return static_cast<std::uint32_t>(std::int64_t{coordinate} - offset);
}

int width_of(const std::vector<coded::Coordinates>& positions) {
  std::uint32_t all = 0;  // the widest has the highest bit
  for (const coded::Coordinates& p : positions) all |= p[0] | p[1] | p[2];
  return std::bit_width(all);
}

geometry::Point offset_of(const std::vector<geometry::Point>& positions) {
  if (positions.empty()) return {};
  geometry::Point least = positions.front();
  for (const geometry::Point& p : positions)
    for (int axis = 0; axis < 3; ++axis) least[axis] = std::min(least[axis], p[axis]);
  return least;
}

void check_encodable(const coded::CubeMesh& cube) {
  const std::size_t n = cube.positions.size();
  COLOSSUS_CHECK(n <= std::numeric_limits<std::uint32_t>::max(), "{} vertices", n);
  COLOSSUS_CHECK(cube.normals.size() == (cube.has_normals ? n : 0), "{} normals", cube.normals.size());
  COLOSSUS_CHECK(cube.colors.size() == (cube.has_colors ? n : 0), "{} colours", cube.colors.size());
  COLOSSUS_CHECK(cube.parents.size() == (cube.has_parents ? n : 0), "{} parents", cube.parents.size());
  for (const geometry::Point& p : cube.positions)
    COLOSSUS_CHECK(std::min({p.x, p.y, p.z}) >= kLeastCoordinate, "position {} {} {}", p.x, p.y, p.z);
}

}  // namespace

Payload encode(const coded::CubeMesh& cube, const Codec& codec) {
  check_encodable(cube);
  coded::CodedNode node;
  node.is_cube = true;
  node.has_normals = cube.has_normals;
  node.has_colors = cube.has_colors;
  node.has_parents = cube.has_parents;
  node.offset = offset_of(cube.positions);
  coded::CodedPart part;
  part.positions.reserve(cube.positions.size());
  for (const geometry::Point& p : cube.positions)
    part.positions.push_back(
        {difference(p.x, node.offset.x), difference(p.y, node.offset.y), difference(p.z, node.offset.z), 0});
  part.normals = cube.normals;
  part.colors = cube.colors;
  part.parents = cube.parents;
  part.triangles = cube.triangles;
  node.position_bits = width_of(part.positions);
  node.parts.push_back(std::move(part));
  return to_payload(node, codec);
}

core::Result<coded::CubeMesh> decode_cube(std::span<const std::byte> bytes, const NodeCounts& most) {
  auto coded = from_payload(bytes, most);
  if (!coded) return coded.defect();
  coded::CodedNode& node = coded.value();
  if (!node.is_cube) return Defect{"expected a cube's node, found one of tetrahedra", 3};
  coded::CodedPart& part = node.parts[0];
  coded::CubeMesh cube{node.has_normals, node.has_colors, node.has_parents, {}, {}, {}, {}, {}};
  cube.positions.reserve(part.positions.size());
  for (const coded::Coordinates& p : part.positions) {
    geometry::Point point;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t coordinate = std::int64_t{node.offset[axis]} + p[static_cast<std::size_t>(axis)];
      if (coordinate > std::numeric_limits<std::int32_t>::max())
        return Defect{"a coordinate is out of range", 0};
      point[axis] = static_cast<std::int32_t>(coordinate);
    }
    cube.positions.push_back(point);
  }
  // Equal cubes are equal nodes.
  if (width_of(part.positions) != node.position_bits)
    return Defect{"the position bits are not those of the widest axis", 2};
  if (offset_of(cube.positions) != node.offset) return Defect{"the offset is not the least coordinate", 0};
  if (std::min({node.offset.x, node.offset.y, node.offset.z}) < kLeastCoordinate)
    return Defect{"the offset is out of range", 0};
  if (coded::used_vertices(part.triangles, part.positions.size()) > part.positions.size())
    return Defect{"vertices are not in order of first use", 0};
  cube.normals = std::move(part.normals);
  cube.colors = std::move(part.colors);
  cube.parents = std::move(part.parents);
  cube.triangles = std::move(part.triangles);
  return cube;
}

}  // namespace colossus::codec
