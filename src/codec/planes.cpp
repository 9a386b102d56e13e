#include "codec/planes.hpp"

namespace colossus::codec {
namespace {

template <std::size_t kComponents>
void put_planes(core::ByteWriter& writer, std::span<const std::array<std::uint8_t, kComponents>> values) {
  for (std::size_t component = 0; component < kComponents; ++component)
    for (const auto& value : values) writer.put(value[component]);
}

template <std::size_t kComponents>
std::vector<std::array<std::uint8_t, kComponents>> values_of(std::span<const std::byte> planes) {
  std::vector<std::array<std::uint8_t, kComponents>> values(planes.size() / kComponents);
  for (std::size_t component = 0; component < kComponents; ++component)
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i][component] = std::to_integer<std::uint8_t>(planes[component * values.size() + i]);
  return values;
}

}  // namespace

void put_start(core::ByteWriter& writer, const std::array<std::uint8_t, 5>& bytes) { writer.put(bytes); }

std::size_t narrowest_bytes(std::size_t largest) { return largest <= 0xff ? 1 : largest <= 0xffff ? 2 : 4; }

void put_sized(core::ByteWriter& writer, std::uint32_t value, std::size_t bytes) {
  writer.put_bytes(std::as_bytes(std::span<const std::uint32_t, 1>(&value, 1)).first(bytes));
}

std::uint32_t get_sized(std::span<const std::byte> plane, std::size_t index, std::size_t bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, plane.data() + index * bytes, bytes);
  return value;
}

void put_normals(core::ByteWriter& writer, std::span<const OctahedralNormal> normals) {
  put_planes<2>(writer, normals);
}

void put_colors(core::ByteWriter& writer, std::span<const mesh::Color> colors) {
  put_planes<4>(writer, colors);
}

std::vector<OctahedralNormal> normals_of(std::span<const std::byte> planes) { return values_of<2>(planes); }

std::vector<mesh::Color> colors_of(std::span<const std::byte> planes) { return values_of<4>(planes); }

// A stored number can be as large as the number of vertices: vertex 0, seen after the last new one.
std::uint64_t triangle_plane_bytes(std::uint64_t vertex_count, std::uint64_t triangle_count) {
  return 3 * triangle_count * narrowest_bytes(vertex_count);
}

void put_triangles(core::ByteWriter& writer, std::span<const mesh::Triangle> triangles,
                   std::size_t vertex_count) {
  // Counted back from the highest index so far: small numbers, 0 for a new vertex.
  std::uint32_t high_water = 0;
  const std::size_t size = narrowest_bytes(vertex_count);
  for (const mesh::Triangle& t : triangles)
    for (const std::uint32_t v : t) {
      COLOSSUS_CHECK(v <= high_water, "vertices are not in order of first use");
      put_sized(writer, high_water - v, size);
      if (v == high_water) ++high_water;
    }
  COLOSSUS_CHECK(high_water <= vertex_count, "vertex {} of {}", high_water - 1, vertex_count);
}

core::Result<PlaneTriangles> triangles_of(std::span<const std::byte> plane, std::uint32_t vertex_count,
                                          std::uint32_t triangle_count, std::uint64_t offset) {
  const std::size_t size = narrowest_bytes(vertex_count);
  PlaneTriangles result;
  result.triangles.resize(triangle_count);
  std::uint32_t high_water = 0;
  for (std::size_t corner = 0; corner < 3 * std::size_t{triangle_count}; ++corner) {
    const std::uint32_t back = get_sized(plane, corner, size);
    if (back > high_water || (back == 0 && high_water >= vertex_count))
      return core::Defect{"a vertex index is out of range", offset + corner * size};
    result.triangles[corner / 3][corner % 3] = high_water - back;
    if (back == 0) ++high_water;
  }
  result.used_vertices = high_water;
  return result;
}

}  // namespace colossus::codec
