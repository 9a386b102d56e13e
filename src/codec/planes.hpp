// What the payloads of all schemes have in common: numbers of so many bytes, vertex attributes as one plane
// per component, and triangles that count back from the newest vertex. schemas/container.md describes the
// bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/bytes.hpp"
#include "core/error.hpp"
#include "mesh/mesh.hpp"

namespace colossus::codec {

using OctahedralNormal = std::array<std::uint8_t, 2>;

// Every payload begins with its codec's number and version, and three bytes of that codec's own.
void put_start(core::ByteWriter& writer, const std::array<std::uint8_t, 5>& bytes);

// 1, 2 or 4: the narrowest that holds this and all smaller numbers.
std::size_t narrowest_bytes(std::size_t largest);

// The low `bytes` bytes of a value, and back; the plane has to be long enough.
void put_sized(core::ByteWriter& writer, std::uint32_t value, std::size_t bytes);
std::uint32_t get_sized(std::span<const std::byte> plane, std::size_t index, std::size_t bytes);

void put_normals(core::ByteWriter& writer, std::span<const OctahedralNormal> normals);
void put_colors(core::ByteWriter& writer, std::span<const mesh::Color> colors);

// From 2 and 4 planes one after the other, of equal lengths.
std::vector<OctahedralNormal> normals_of(std::span<const std::byte> planes);
std::vector<mesh::Color> colors_of(std::span<const std::byte> planes);

// The triangles' part of a payload.
std::uint64_t triangle_plane_bytes(std::uint64_t vertex_count, std::uint64_t triangle_count);

// Vertices must be in order of first use. Those that no triangle uses come last.
void put_triangles(core::ByteWriter& writer, std::span<const mesh::Triangle> triangles,
                   std::size_t vertex_count);

struct PlaneTriangles {
  std::vector<mesh::Triangle> triangles;
  std::uint32_t used_vertices = 0;  // the first so many; at most vertex_count
};

// A plane of triangle_plane_bytes() bytes; `offset` is its place in the payload. A Defect when an index is
// not one of vertex_count, or skips a vertex.
core::Result<PlaneTriangles> triangles_of(std::span<const std::byte> plane, std::uint32_t vertex_count,
                                          std::uint32_t triangle_count, std::uint64_t offset);

}  // namespace colossus::codec
