#include "codec/cube_codec.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "codec/planes.hpp"

namespace colossus::codec {
namespace {

using core::ByteReader;
using core::ByteWriter;
using core::Defect;

constexpr std::uint8_t kCodec = 2;
constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kNormalsFlag = 1;
constexpr std::uint8_t kColorsFlag = 2;
constexpr std::uint8_t kParentsFlag = 4;
constexpr int kMaxWidth = 32;
constexpr std::int32_t kLeastCoordinate = -(std::int32_t{1} << 30);

struct Header {
  int width = 0;                 // bits that the widest axis needs
  std::size_t parent_bytes = 0;  // of a parent's index; 0 without parents
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
  geometry::Point offset;  // the least of each coordinate; 0 without vertices
};

// At least one, so that no vertex is without bytes: what a payload decodes to is bounded by its size.
std::size_t position_bytes(int width) { return static_cast<std::size_t>(std::max(1, (width + 7) / 8)); }

std::uint32_t difference(std::int32_t coordinate, std::int32_t offset) {
  return static_cast<std::uint32_t>(std::int64_t{coordinate} - offset);
}

int width_of(const std::vector<geometry::Point>& positions, const geometry::Point& offset) {
  std::uint32_t all = 0;  // the widest has the highest bit
  for (const geometry::Point& p : positions)
    for (int axis = 0; axis < 3; ++axis) all |= difference(p[axis], offset[axis]);
  return std::bit_width(all);
}

geometry::Point offset_of(const std::vector<geometry::Point>& positions) {
  if (positions.empty()) return {};
  geometry::Point least = positions.front();
  for (const geometry::Point& p : positions)
    for (int axis = 0; axis < 3; ++axis) least[axis] = std::min(least[axis], p[axis]);
  return least;
}

std::size_t parent_bytes_of(const CubeMesh& cube) {
  if (!cube.has_parents) return 0;
  return narrowest_bytes(cube.parents.empty() ? 0
                                              : *std::max_element(cube.parents.begin(), cube.parents.end()));
}

Header header_of(const CubeMesh& cube) {
  const geometry::Point offset = offset_of(cube.positions);
  return {width_of(cube.positions, offset), parent_bytes_of(cube),
          static_cast<std::uint32_t>(cube.positions.size()),
          static_cast<std::uint32_t>(cube.triangles.size()), offset};
}

// Per axis one plane per byte, the lowest first: the high bytes of neighbours are alike.
void put_positions(ByteWriter& writer, const CubeMesh& cube, const Header& header) {
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t byte = 0; byte < position_bytes(header.width); ++byte)
      for (const geometry::Point& p : cube.positions)
        writer.put(static_cast<std::uint8_t>(difference(p[axis], header.offset[axis]) >> 8 * byte));
}

core::Result<std::vector<geometry::Point>> positions_of(std::span<const std::byte> planes,
                                                        const Header& header, std::uint64_t start) {
  const std::size_t bytes = position_bytes(header.width);
  const std::size_t n = header.vertices;
  std::vector<geometry::Point> positions(n);
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t value = 0;
      for (std::size_t byte = 0; byte < bytes; ++byte) {
        const std::size_t plane = static_cast<std::size_t>(axis) * bytes + byte;
        value |= std::to_integer<std::uint32_t>(planes[plane * n + i]) << 8 * byte;
      }
      const std::int64_t coordinate = std::int64_t{header.offset[axis]} + value;
      if (coordinate > std::numeric_limits<std::int32_t>::max())
        return Defect{"a coordinate is out of range", start + static_cast<std::size_t>(axis) * bytes * n + i};
      positions[i][axis] = static_cast<std::int32_t>(coordinate);
    }
  return positions;
}

core::Result<Header> get_header(ByteReader& reader, CubeMesh& cube) {
  const auto codec = reader.get<std::uint8_t>();
  const auto version = reader.get<std::uint8_t>();
  const auto flags = reader.get<std::uint8_t>();
  Header header;
  header.width = reader.get<std::uint8_t>();
  header.parent_bytes = reader.get<std::uint8_t>();
  header.vertices = reader.get<std::uint32_t>();
  header.triangles = reader.get<std::uint32_t>();
  for (int axis = 0; axis < 3; ++axis) header.offset[axis] = reader.get<std::int32_t>();
  if (reader.failed()) return Defect{"the cube's header is cut short", 0};
  if (codec != kCodec || version != kVersion)
    return Defect{
        fmt::format("codec {} version {} is unknown; this program reads codec 2 version 1", codec, version),
        0};
  if (flags > (kNormalsFlag | kColorsFlag | kParentsFlag)) return Defect{"unknown attribute flags", 2};
  if (header.width > kMaxWidth) return Defect{"a coordinate is wider than 32 bits", 3};
  cube.has_normals = (flags & kNormalsFlag) != 0;
  cube.has_colors = (flags & kColorsFlag) != 0;
  cube.has_parents = (flags & kParentsFlag) != 0;
  const std::size_t size = header.parent_bytes;
  if (cube.has_parents ? size != 1 && size != 2 && size != 4 : size != 0)
    return Defect{"the size of parent indices is out of range", 4};
  for (int axis = 0; axis < 3; ++axis)
    if (header.offset[axis] < kLeastCoordinate) return Defect{"the offset is out of range", 13};
  return header;
}

void check_encodable(const CubeMesh& cube) {
  const std::size_t n = cube.positions.size();
  COLOSSUS_CHECK(n <= std::numeric_limits<std::uint32_t>::max(), "{} vertices", n);
  COLOSSUS_CHECK(cube.normals.size() == (cube.has_normals ? n : 0), "{} normals", cube.normals.size());
  COLOSSUS_CHECK(cube.colors.size() == (cube.has_colors ? n : 0), "{} colours", cube.colors.size());
  COLOSSUS_CHECK(cube.parents.size() == (cube.has_parents ? n : 0), "{} parents", cube.parents.size());
  for (const geometry::Point& p : cube.positions)
    COLOSSUS_CHECK(std::min({p.x, p.y, p.z}) >= kLeastCoordinate, "position {} {} {}", p.x, p.y, p.z);
}

}  // namespace

core::Bytes encode(const CubeMesh& cube) {
  check_encodable(cube);
  const Header header = header_of(cube);
  ByteWriter writer;
  const auto flags =
      static_cast<std::uint8_t>((cube.has_normals ? kNormalsFlag : 0) | (cube.has_colors ? kColorsFlag : 0) |
                                (cube.has_parents ? kParentsFlag : 0));
  put_start(writer, {kCodec, kVersion, flags, static_cast<std::uint8_t>(header.width),
                     static_cast<std::uint8_t>(header.parent_bytes)});
  writer.put(header.vertices);
  writer.put(header.triangles);
  for (int axis = 0; axis < 3; ++axis) writer.put(header.offset[axis]);
  put_positions(writer, cube, header);
  put_normals(writer, cube.normals);
  put_colors(writer, cube.colors);
  for (const std::uint32_t parent : cube.parents) put_sized(writer, parent, header.parent_bytes);
  put_triangles(writer, cube.triangles, cube.positions.size());
  return writer.take();
}

core::Result<CubeMesh> decode_cube(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  CubeMesh cube;
  const auto header = get_header(reader, cube);
  if (!header) return header.defect();
  const Header& h = header.value();
  const std::uint64_t n = h.vertices;
  const std::uint64_t start = reader.offset();
  const auto planes = reader.get_bytes(3 * position_bytes(h.width) * n);
  const auto normals = reader.get_bytes(cube.has_normals ? 2 * n : 0);
  const auto colors = reader.get_bytes(cube.has_colors ? 4 * n : 0);
  const std::uint64_t parent_start = reader.offset();
  const auto parents = reader.get_bytes(h.parent_bytes * n);
  const std::uint64_t triangle_start = reader.offset();
  const auto indices = reader.get_bytes(triangle_plane_bytes(n, h.triangles));
  if (reader.failed()) return Defect{"the cube is cut short", start};
  if (reader.remaining() != 0) return Defect{"bytes left over after the triangles", reader.offset()};

  auto positions = positions_of(planes, h, start);
  if (!positions) return positions.defect();
  cube.positions = std::move(positions).value();
  cube.normals = normals_of(normals);
  cube.colors = colors_of(colors);
  cube.parents.resize(cube.has_parents ? n : 0);
  for (std::size_t i = 0; i < cube.parents.size(); ++i)
    cube.parents[i] = get_sized(parents, i, h.parent_bytes);
  auto triangles = triangles_of(indices, h.vertices, h.triangles, triangle_start);
  if (!triangles) return triangles.defect();
  cube.triangles = std::move(triangles.value().triangles);

  // One cube has one encoding, so equal cubes are equal bytes.
  if (offset_of(cube.positions) != h.offset) return Defect{"the offset is not the least coordinate", 13};
  if (width_of(cube.positions, h.offset) != h.width)
    return Defect{"the width is not that of the widest axis", 3};
  if (parent_bytes_of(cube) != h.parent_bytes)
    return Defect{"parent indices are wider than they need to be", parent_start};
  return cube;
}

}  // namespace colossus::codec
