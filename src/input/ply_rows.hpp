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

// The properties that are a colour: red, green, blue, alpha, or kUnused.
using ColorProperties = std::array<int, 4>;
inline constexpr ColorProperties kNoColorProperties{kUnused, kUnused, kUnused, kUnused};

// All three of red, green, blue (or diffuse_red ..., or r, g, b), in any case, as scalars; alpha if there is
// one.
ColorProperties find_color(const PlyElement& element);
// Whether at least one of these properties is of floats.
bool has_floats(const PlyElement& element, const ColorProperties& color);

struct VertexLayout {
  std::array<int, 10> property;  // by slot: index of the property, or kUnused
  std::vector<int> slot;         // by property: its slot, or kUnused
  bool has_normals = false;      // all three components
  bool has_colors = false;
  bool has_float_colors = false;  // at least one component
};

// Throws Error(kBadData) when x, y or z is missing or a list.
VertexLayout make_vertex_layout(const SourceInfo& info, const PlyElement& element);

// The index list of a face or tristrips element (vertex_indices, vertex_index). Throws Error(kBadData)
// without one, or for one of floats unless `is_lenient`.
int find_index_list(const SourceInfo& info, const PlyElement& element, bool is_lenient);

// Stores a property's value, a colour converted by its type.
void set_slot(int slot, PlyType type, double value, VertexValues& values, Remarks& remarks);

// One value of a binary file; `swap` where its byte order is not ours. load_int is for integer types; values
// above the range of 64 signed bits become negative.
double load_double(PlyType type, bool swap, const std::byte* at);
std::int64_t load_int(PlyType type, bool swap, const std::byte* at);

// `count` vertices from rows without lists. Cost: some nanoseconds per vertex.
VertexBlock convert_vertex_rows(const VertexLayout& layout, const PlyElement& element, bool swap,
                                std::span<const std::byte> rows, std::uint64_t first, std::size_t count,
                                Remarks& remarks);

// A scalar in a row of fixed size.
struct RowColumn {
  bool exists = false;
  std::size_t offset = 0;
  PlyType type = PlyType::kUint8;
};

// Rows of a face element whose only list is the index list, under the assumption that all lists have three
// items.
struct TriangleRows {
  std::size_t stride = 0;       // of a row
  std::size_t list_offset = 0;  // of the list's count in a row
  PlyType count_type = PlyType::kUint8;
  PlyType index_type = PlyType::kInt32;
  std::array<RowColumn, 4> color;  // of the face
  bool swap = false;
};

// Nothing if the element has another list or none, or the indices are floats.
std::optional<TriangleRows> make_triangle_rows(const PlyElement& element, int index_list,
                                               const ColorProperties& color, bool swap);

// Whether all lists have three items.
bool are_all_triangles(const TriangleRows& layout, std::span<const std::byte> rows, std::size_t count);

// The triangles of rows that are all triangles, unchecked, with their colours; and the first row with an
// index below 0 or of at least vertex_count, or `count`. Cost: about a nanosecond per triangle.
struct ConvertedTriangles {
  TriangleBlock block;
  std::size_t first_bad = 0;
  std::int64_t bad_index = 0;
};
// `first` is the number of the first one.
ConvertedTriangles convert_triangle_rows(const TriangleRows& layout, std::span<const std::byte> rows,
                                         std::uint64_t first, std::size_t count, std::uint64_t vertex_count,
                                         Remarks& remarks);

}  // namespace colossus::input
