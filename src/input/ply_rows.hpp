// What the elements of a PLY file mean to us, and fast conversion of binary rows of fixed size.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "input/blocks.hpp"
#include "input/ply_header.hpp"
#include "input/source.hpp"

namespace colossus::input {

enum class PlyRole : std::uint8_t { kOther, kVertex, kFace, kStrips };

// By name: vertex, face, tristrips.
PlyRole role_of(const PlyElement& element);

// The place of a vertex property in VertexValues: 0-2 position, 3-5 normal, 6-9 colour, or not used.
inline constexpr int kUnused = -1;

struct VertexLayout {
  std::array<int, 10> property;  // by slot: index of the property, or kUnused
  std::vector<int> slot;         // by property: its slot, or kUnused
  bool has_normals = false;      // all three components
  bool has_colors = false;       // all three of red, green, blue (or diffuse_red ..., or r, g, b)
};

// Throws Error(kBadData) when x, y or z is missing or a list.
VertexLayout make_vertex_layout(const SourceInfo& info, const PlyElement& element);

// The index list of a face or tristrips element (vertex_indices, vertex_index). Throws Error(kBadData)
// without one.
int find_index_list(const SourceInfo& info, const PlyElement& element);

// Stores a property's value, a colour converted by its type. Throws Error(kBadData) for a colour that is NaN.
void set_slot(const SourceInfo& info, std::uint64_t vertex, int slot, PlyType type, double value,
              VertexValues& values);

// One value of a binary file; `swap` where its byte order is not ours. load_int is for integer types; values
// above the range of 64 signed bits become negative.
double load_double(PlyType type, bool swap, const std::byte* at);
std::int64_t load_int(PlyType type, bool swap, const std::byte* at);

// `count` vertices from rows without lists. Throws Error(kBadData) for coordinates that are not finite. Cost:
// some nanoseconds per vertex.
VertexBlock convert_vertex_rows(const SourceInfo& info, const VertexLayout& layout, const PlyElement& element,
                                bool swap, std::span<const std::byte> rows, std::uint64_t first,
                                std::size_t count);

// Rows of a face element whose only list is the index list, under the assumption that all lists have three
// items.
struct TriangleRows {
  std::size_t stride = 0;       // of a row
  std::size_t list_offset = 0;  // of the list's count in a row
  PlyType count_type = PlyType::kUint8;
  PlyType index_type = PlyType::kInt32;
  bool swap = false;
};

// Nothing if the element has another list or none.
std::optional<TriangleRows> make_triangle_rows(const PlyElement& element, int index_list, bool swap);

// Whether all lists have three items.
bool are_all_triangles(const TriangleRows& layout, std::span<const std::byte> rows, std::size_t count);

// The triangles of rows that are all triangles, unchecked; and the first row with an index below 0 or of at
// least vertex_count, or `count`. Cost: about a nanosecond per triangle.
struct ConvertedTriangles {
  TriangleBlock block;
  std::size_t first_bad = 0;
  std::int64_t bad_index = 0;
};
ConvertedTriangles convert_triangle_rows(const TriangleRows& layout, std::span<const std::byte> rows,
                                         std::size_t count, std::uint64_t vertex_count);

}  // namespace colossus::input
