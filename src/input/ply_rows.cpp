#include "input/ply_rows.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

template <typename T, bool kSwap>
T load(const std::byte* at) {
  using Bits =
      std::conditional_t<sizeof(T) == 8, std::uint64_t,
                         std::conditional_t<sizeof(T) == 4, std::uint32_t,
                                            std::conditional_t<sizeof(T) == 2, std::uint16_t, std::uint8_t>>>;
  Bits bits;
  std::memcpy(&bits, at, sizeof(T));
  if constexpr (kSwap && sizeof(T) == 8) bits = __builtin_bswap64(bits);
  if constexpr (kSwap && sizeof(T) == 4) bits = __builtin_bswap32(bits);
  if constexpr (kSwap && sizeof(T) == 2) bits = __builtin_bswap16(bits);
  return std::bit_cast<T>(bits);
}

// Calls function.operator()<T, kSwap>() for the C++ type of `type`.
template <bool kSwap, typename Function>
auto dispatch_type(PlyType type, const Function& function) {
  switch (type) {
    case PlyType::kInt8:
      return function.template operator()<std::int8_t, kSwap>();
    case PlyType::kUint8:
      return function.template operator()<std::uint8_t, kSwap>();
    case PlyType::kInt16:
      return function.template operator()<std::int16_t, kSwap>();
    case PlyType::kUint16:
      return function.template operator()<std::uint16_t, kSwap>();
    case PlyType::kInt32:
      return function.template operator()<std::int32_t, kSwap>();
    case PlyType::kUint32:
      return function.template operator()<std::uint32_t, kSwap>();
    case PlyType::kInt64:
      return function.template operator()<std::int64_t, kSwap>();
    case PlyType::kUint64:
      return function.template operator()<std::uint64_t, kSwap>();
    case PlyType::kFloat32:
      return function.template operator()<float, kSwap>();
    default:
      return function.template operator()<double, kSwap>();
  }
}

template <typename Function>
auto dispatch(PlyType type, bool swap, const Function& function) {
  return swap ? dispatch_type<true>(type, function) : dispatch_type<false>(type, function);
}

// Values of one property, every `stride` bytes, to every `step`-th of `out`.
void convert_column(PlyType type, bool swap, const std::byte* rows, std::size_t stride, std::size_t count,
                    double* out, std::size_t step) {
  dispatch(type, swap, [&]<typename T, bool kSwap>() {
    for (std::size_t i = 0; i < count; ++i)
      out[i * step] = static_cast<double>(load<T, kSwap>(rows + i * stride));
  });
}

std::uint8_t color_from_int(PlyType type, double value) {
  return color_from_byte(type == PlyType::kUint16 ? value / 257 : value);
}

// One component of colours of unknown scale. Marks rows in which it is not a number; an alpha then is 255.
void convert_float_color(std::span<const double> column, std::size_t k, std::vector<Color>& colors,
                         std::vector<Color>& byte_colors, std::vector<bool>& is_undefined,
                         std::uint64_t first, Remarks& remarks) {
  double greatest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < column.size(); ++i) {
    colors[i][k] = color_from_unit(column[i]);
    byte_colors[i][k] = color_from_byte(column[i]);
    if (!std::isnan(column[i])) [[likely]] {
      greatest = std::max(greatest, column[i]);
    } else if (k == 3) {
      colors[i][k] = byte_colors[i][k] = kNoColor[k];
      remarks.undefined_alphas.add(first + i);
    } else {
      is_undefined.resize(column.size(), false);
      is_undefined[i] = true;
    }
  }
  note_color(k, greatest, remarks);
}

// The colours of `count` rows of `stride` bytes, the first of which is number `first`.
void convert_colors(const std::array<RowColumn, 4>& columns, bool swap, std::span<const std::byte> rows,
                    std::size_t stride, std::uint64_t first, std::size_t count, std::vector<Color>& colors,
                    std::vector<Color>& byte_colors, Remarks& remarks) {
  remarks.has_colors = 1;
  colors.assign(count, {0, 0, 0, 255});
  const bool has_both = std::any_of(columns.begin(), columns.end(), [](const RowColumn& column) {
    return column.exists && is_float(column.type);
  });
  std::vector<double> values;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const RowColumn& column = columns[k];
    if (!column.exists || is_float(column.type)) continue;
    const std::byte* at = rows.data() + column.offset;
    if (column.type == PlyType::kUint8) {
      for (std::size_t i = 0; i < count; ++i) colors[i][k] = std::to_integer<std::uint8_t>(at[i * stride]);
      continue;
    }
    values.resize(count);
    convert_column(column.type, swap, at, stride, count, values.data(), 1);
    for (std::size_t i = 0; i < count; ++i) colors[i][k] = color_from_int(column.type, values[i]);
  }
  if (!has_both) return;
  byte_colors = colors;
  std::vector<bool> is_undefined;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const RowColumn& column = columns[k];
    if (!column.exists || !is_float(column.type)) continue;
    values.resize(count);
    convert_column(column.type, swap, rows.data() + column.offset, stride, count, values.data(), 1);
    convert_float_color(values, k, colors, byte_colors, is_undefined, first, remarks);
  }
  for (std::size_t i = 0; i < is_undefined.size(); ++i) {
    if (!is_undefined[i]) continue;
    colors[i] = byte_colors[i] = kNoColor;
    remarks.undefined_colors.add(first + i);
  }
}

std::size_t offset_of(const PlyElement& element, int property) {
  std::size_t offset = 0;
  for (int i = 0; i < property; ++i) offset += ply_size(element.properties[i].type);
  return offset;
}

// Of a row in which all properties before this one are scalars.
RowColumn column_of(const PlyElement& element, int property) {
  if (property == kUnused) return {};
  return {true, offset_of(element, property), element.properties[static_cast<std::size_t>(property)].type};
}

// Where each slot of `layout` finds its values in fixed rows.
class Columns {
 public:
  Columns(const VertexLayout& layout, const PlyElement& element, bool swap, std::span<const std::byte> rows,
          std::size_t count)
      : layout_(layout), element_(element), swap_(swap), rows_(rows), count_(count) {}
  PlyType type(int slot) const { return element_.properties[layout_.property[slot]].type; }
  const std::byte* begin(int slot) const {
    return rows_.data() + offset_of(element_, layout_.property[slot]);
  }
  void convert(int slot, double* out, std::size_t step) const {
    convert_column(type(slot), swap_, begin(slot), element_.row_bytes, count_, out, step);
  }

 private:
  const VertexLayout& layout_;
  const PlyElement& element_;
  bool swap_;
  std::span<const std::byte> rows_;
  std::size_t count_;
};

}  // namespace

PlyRole role_of(const PlyElement& element) {
  if (element.name == "vertex") return PlyRole::kVertex;
  if (element.name == "face") return PlyRole::kFace;
  if (element.name == "tristrips") return PlyRole::kStrips;
  return PlyRole::kOther;
}

bool has_floats(const PlyElement& element, const ColorProperties& color) {
  return std::any_of(color.begin(), color.end(), [&](int property) {
    return property != kUnused && is_float(element.properties[static_cast<std::size_t>(property)].type);
  });
}

ColorProperties find_color(const PlyElement& element) {
  const auto scalar = [&](std::string_view name) {
    const auto is_it = [&](const PlyProperty& property) {
      return !property.is_list &&
             std::equal(property.name.begin(), property.name.end(), name.begin(), name.end(),
                        [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a + 32 : a) == b; });
    };
    const auto& properties = element.properties;
    const auto found = std::find_if(properties.begin(), properties.end(), is_it);
    return found == properties.end() ? kUnused : static_cast<int>(found - properties.begin());
  };
  using Names = std::array<std::string_view, 4>;
  for (const Names& names :
       {Names{"red", "green", "blue", "alpha"},
        Names{"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"}, Names{"r", "g", "b", "a"}}) {
    const ColorProperties color{scalar(names[0]), scalar(names[1]), scalar(names[2]), scalar(names[3])};
    if (color[0] != kUnused && color[1] != kUnused && color[2] != kUnused) return color;
  }
  return kNoColorProperties;
}

VertexLayout make_vertex_layout(const SourceInfo& info, const PlyElement& element) {
  const auto scalar = [&](std::string_view name) {
    const int property = element.find(name);
    return property >= 0 && !element.properties[property].is_list ? property : kUnused;
  };
  VertexLayout layout;
  layout.property.fill(kUnused);
  const auto set_three = [&](int slot, const std::array<std::string_view, 3>& names) {
    std::array<int, 3> found;
    for (int i = 0; i < 3; ++i) found[i] = scalar(names[i]);
    if (found[0] < 0 || found[1] < 0 || found[2] < 0) return false;
    std::copy(found.begin(), found.end(), layout.property.begin() + slot);
    return true;
  };
  if (!set_three(0, {"x", "y", "z"}))
    fail(Status::kBadData, "{}: header: element vertex: expected properties x, y and z that are no lists",
         info.path.string());
  layout.has_normals = set_three(3, {"nx", "ny", "nz"});
  const ColorProperties color = find_color(element);
  std::copy(color.begin(), color.end(), layout.property.begin() + 6);
  layout.has_colors = color[0] != kUnused;
  layout.has_float_colors = has_floats(element, color);
  layout.slot.assign(element.properties.size(), kUnused);
  for (int slot = 0; slot < 10; ++slot)
    if (layout.property[slot] >= 0) layout.slot[layout.property[slot]] = slot;
  return layout;
}

int find_index_list(const SourceInfo& info, const PlyElement& element, bool is_lenient) {
  const int plural = element.find("vertex_indices");
  const int property = plural >= 0 ? plural : element.find("vertex_index");
  if (property < 0 || !element.properties[property].is_list)
    fail(Status::kBadData, "{}: header: element {}: expected an integer list vertex_indices or vertex_index",
         info.path.string(), element.name);
  if (is_float(element.properties[property].type) && !is_lenient)
    fail(Status::kBadData,
         "{}: header: element {}: expected an integer list {}, found floats; --lenient lets them pass",
         info.path.string(), element.name, element.properties[property].name);
  return property;
}

void set_slot(int slot, PlyType type, double value, VertexValues& values, Remarks& remarks) {
  if (slot < 0) return;
  if (slot < 3) {
    values.position[slot] = value;
  } else if (slot < 6) {
    values.normal[slot - 3] = value;
  } else {
    const auto k = static_cast<std::size_t>(slot - 6);
    if (is_float(type))
      values.set_color(k, value, remarks);
    else
      values.color.set_known(k, color_from_int(type, value));
  }
}

double load_double(PlyType type, bool swap, const std::byte* at) {
  return dispatch(type, swap,
                  [&]<typename T, bool kSwap>() { return static_cast<double>(load<T, kSwap>(at)); });
}

std::int64_t load_int(PlyType type, bool swap, const std::byte* at) {
  return dispatch(type, swap, [&]<typename T, bool kSwap>() -> std::int64_t {
    if constexpr (std::is_integral_v<T>) return static_cast<std::int64_t>(load<T, kSwap>(at));
    return -1;
  });
}

VertexBlock convert_vertex_rows(const VertexLayout& layout, const PlyElement& element, bool swap,
                                std::span<const std::byte> rows, std::uint64_t first, std::size_t count,
                                Remarks& remarks) {
  COLOSSUS_CHECK(!element.has_list && rows.size() == count * element.row_bytes);
  const Columns columns(layout, element, swap, rows, count);
  VertexBlock block;
  block.positions.resize(count);
  for (int axis = 0; axis < 3; ++axis) columns.convert(axis, block.positions.data()->data() + axis, 3);
  for (std::size_t i = 0; i < count; ++i)
    if (!is_finite(block.positions[i])) [[unlikely]]
      remarks.undefined_positions.add(first + i);
  if (layout.has_normals) {
    std::vector<double> column(3 * count);
    for (int axis = 0; axis < 3; ++axis) columns.convert(3 + axis, column.data() + axis, 3);
    block.normals.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::array<double, 3> normal{column[3 * i], column[3 * i + 1], column[3 * i + 2]};
      if (!is_normal(normal)) [[unlikely]]
        remarks.undefined_normals.add(first + i);
      block.normals[i] = normal_or_zero(normal);
    }
  }
  if (layout.has_colors) {
    std::array<RowColumn, 4> color;
    for (std::size_t k = 0; k < 4; ++k) color[k] = column_of(element, layout.property[6 + k]);
    convert_colors(color, swap, rows, element.row_bytes, first, count, block.colors, block.byte_colors,
                   remarks);
  }
  return block;
}

std::optional<TriangleRows> make_triangle_rows(const PlyElement& element, int index_list,
                                               const ColorProperties& color, bool swap) {
  const PlyProperty& list = element.properties[static_cast<std::size_t>(index_list)];
  if (is_float(list.type) || is_float(list.count_type)) return {};
  TriangleRows layout;
  layout.swap = swap;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (static_cast<int>(i) == index_list) {
      layout.list_offset = layout.stride;
      layout.count_type = property.count_type;
      layout.index_type = property.type;
      layout.stride += ply_size(property.count_type) + 3 * ply_size(property.type);
    } else if (property.is_list) {
      return {};
    } else {
      for (std::size_t k = 0; k < color.size(); ++k)
        if (color[k] == static_cast<int>(i)) layout.color[k] = {true, layout.stride, property.type};
      layout.stride += ply_size(property.type);
    }
  }
  return layout;
}

bool are_all_triangles(const TriangleRows& layout, std::span<const std::byte> rows, std::size_t count) {
  return dispatch(layout.count_type, layout.swap, [&]<typename T, bool kSwap>() {
    bool all = true;
    const std::byte* at = rows.data() + layout.list_offset;
    for (std::size_t i = 0; i < count; ++i) all &= load<T, kSwap>(at + i * layout.stride) == T{3};
    return all;
  });
}

ConvertedTriangles convert_triangle_rows(const TriangleRows& layout, std::span<const std::byte> rows,
                                         std::uint64_t first, std::size_t count, std::uint64_t vertex_count,
                                         Remarks& remarks) {
  COLOSSUS_CHECK(rows.size() == count * layout.stride);
  ConvertedTriangles result;
  if (layout.color[0].exists)
    convert_colors(layout.color, layout.swap, rows, layout.stride, first, count, result.block.colors,
                   result.block.byte_colors, remarks);
  result.block.triangles.resize(count);
  result.first_bad = count;
  const std::byte* begin = rows.data() + layout.list_offset + ply_size(layout.count_type);
  dispatch(layout.index_type, layout.swap, [&]<typename T, bool kSwap>() {
    // A negative index becomes a huge one, so that one comparison finds both kinds of bad ones.
    const auto index = [&](std::size_t row, int corner) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(
          load<T, kSwap>(begin + row * layout.stride + static_cast<std::size_t>(corner) * sizeof(T))));
    };
    std::uint64_t largest = 0;
    for (std::size_t i = 0; i < count; ++i) {
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint64_t value = index(i, corner);
        largest = std::max(largest, value);
        result.block.triangles[i][corner] = static_cast<std::uint32_t>(value);
      }
    }
    if (largest < vertex_count) [[likely]]
      return;
    for (std::size_t i = 0; i < count; ++i) {
      for (int corner = 0; corner < 3; ++corner) {
        if (index(i, corner) < vertex_count) continue;
        result.first_bad = i;
        result.bad_index = static_cast<std::int64_t>(index(i, corner));
        return;
      }
    }
  });
  return result;
}

}  // namespace colossus::input
