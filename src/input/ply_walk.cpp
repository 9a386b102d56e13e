// The sequential reader of binary PLY files, for rows whose size only reading tells.
#include <cmath>

#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/byte_window.hpp"
#include "input/ply_source.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

class Walker {
 public:
  Walker(const PlyReading& reading, std::uint64_t offset)
      : reading_(reading),
        ply_(reading.ply),
        info_(reading.info),
        window_(reading.file, offset, reading.ply.bytes),
        faces_(reading.info, reading.sink, remarks_) {}

  void walk(std::size_t first_element, bool with_vertices) {
    for (std::size_t i = first_element; i < ply_.header.elements.size(); ++i) {
      const PlyElement& element = ply_.header.elements[i];
      const PlyRole role = role_of(element);
      if (!element.has_list) {
        pass_fixed_rows(element, role == PlyRole::kVertex && with_vertices);
      } else if (role == PlyRole::kVertex) {
        walk_vertices(element, with_vertices);
      } else if (role == PlyRole::kOther) {
        for (std::uint64_t row = 0; row < element.count; ++row)
          for (const PlyProperty& property : element.properties) skip_property(element, row, property);
      } else {
        walk_faces(element, role == PlyRole::kStrips);
      }
    }
    faces_.finish();
    check_tail(info_, reading_.options, reading_.file, window_.offset(), remarks_);
    reading_.sink.remarks(remarks_);
  }

 private:
  // `size` bytes, at most ByteWindow::kCapacity.
  const std::byte* take(const PlyElement& element, std::uint64_t row, std::size_t size) {
    const auto bytes = window_.peek(size);
    if (bytes.size() < size) fail_truncated(info_, element, row, window_.offset(), size, bytes.size());
    window_.consume(size);
    return bytes.data();
  }

  // Checked to lie within the file.
  std::uint64_t take_list_count(const PlyElement& element, std::uint64_t row, const PlyProperty& list) {
    const std::byte* at = take(element, row, ply_size(list.count_type));
    const std::int64_t count = load_whole(element, row, list.count_type, at);
    check_list_count(info_, element, row, list, count);
    if (static_cast<std::uint64_t>(count) > window_.remaining() / ply_size(list.type))
      core::fail(core::Status::kBadData,
                 "{}: truncated in {} {} at byte {}: list {} has {} items of {} bytes; found {} bytes",
                 info_.path.string(), element.name, row, window_.offset(), list.name, count,
                 ply_size(list.type), window_.remaining());
    return static_cast<std::uint64_t>(count);
  }

  void skip_property(const PlyElement& element, std::uint64_t row, const PlyProperty& property) {
    if (property.is_list) {
      window_.skip(take_list_count(element, row, property) * ply_size(property.type));
    } else {
      take(element, row, ply_size(property.type));
    }
  }

  void pass_fixed_rows(const PlyElement& element, bool deliver) {
    if (element.row_bytes == 0) return;
    const std::uint64_t fit = window_.remaining() / element.row_bytes;
    if (fit < element.count)
      fail_truncated(info_, element, fit, window_.offset() + fit * element.row_bytes, element.row_bytes,
                     window_.remaining() - fit * element.row_bytes);
    for (std::uint64_t first = 0; deliver && first < element.count; first += kBlockElements) {
      const std::size_t count = std::min<std::uint64_t>(kBlockElements, element.count - first);
      reading_.sink.vertices(first,
                             read_vertex_rows(reading_, element, window_.offset(), first, count, remarks_));
    }
    window_.skip(element.count * element.row_bytes);
  }

  void walk_vertices(const PlyElement& element, bool deliver) {
    VertexCollector vertices(info_, reading_.sink, deliver ? remarks_ : ignored_);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      VertexValues values;
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        const int slot = ply_.vertex_layout.slot[i];
        if (slot == kUnused) {
          skip_property(element, row, property);
          continue;
        }
        const std::byte* at = take(element, row, ply_size(property.type));
        set_slot(slot, property.type, load_double(property.type, ply_.swap, at), values,
                 deliver ? remarks_ : ignored_);
      }
      if (deliver) vertices.add(values);
    }
    vertices.finish();
  }

  void walk_faces(const PlyElement& element, bool is_strips) {
    const std::size_t index_list = find_index_list(info_, element, reading_.options.is_lenient);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      VertexValues color;
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        if (i == index_list) {
          walk_indices(element, row, property, is_strips);
        } else if (const int slot = is_strips ? kUnused : face_color_slot(i); slot != kUnused) {
          const std::byte* at = take(element, row, ply_size(property.type));
          set_slot(slot, property.type, load_double(property.type, ply_.swap, at), color, remarks_);
        } else {
          skip_property(element, row, property);
        }
      }
      is_strips ? faces_.end_strip() : faces_.end_polygon(&color);
    }
  }

  int face_color_slot(std::size_t property) const {
    for (std::size_t k = 0; k < 4; ++k)
      if (ply_.face_color[k] == static_cast<int>(property)) return static_cast<int>(6 + k);
    return kUnused;
  }

  std::int64_t load_whole(const PlyElement& element, std::uint64_t row, PlyType type, const std::byte* at) {
    if (!is_float(type)) return load_int(type, ply_.swap, at);
    const double value = load_double(type, ply_.swap, at);
    if (!(std::abs(value) <= 0x1p53) || std::trunc(value) != value)
      core::fail(core::Status::kBadData, "{}: {} {}: expected an integer, found {}", info_.path.string(),
                 element.name, row, value);
    return static_cast<std::int64_t>(value);
  }

  void walk_indices(const PlyElement& element, std::uint64_t row, const PlyProperty& list, bool is_strips) {
    const std::size_t size = ply_size(list.type);
    std::uint64_t left = take_list_count(element, row, list);
    if (is_float(list.type) || is_float(list.count_type)) remarks_.float_indices.add(row);
    while (left > 0) {
      // A list can be longer than the window.
      const auto bytes = window_.peek(std::min<std::uint64_t>(left * size, ByteWindow::kCapacity / 2));
      const std::size_t count = std::min<std::uint64_t>(left, bytes.size() / size);
      for (std::size_t i = 0; i < count; ++i) {
        const std::int64_t index = load_whole(element, row, list.type, bytes.data() + i * size);
        if (is_strips && index == -1) {
          faces_.end_strip();
          continue;
        }
        if (static_cast<std::uint64_t>(index) >= ply_.vertex_count)
          fail_index(info_, element.name, row, index, ply_.vertex_count);
        is_strips ? faces_.strip_corner(static_cast<std::uint32_t>(index))
                  : faces_.polygon_corner(static_cast<std::uint32_t>(index));
      }
      window_.consume(count * size);
      left -= count;
    }
  }

  const PlyReading& reading_;
  const PlyFile& ply_;
  const SourceInfo& info_;
  ByteWindow window_;
  Remarks remarks_;
  Remarks ignored_;  // of vertices that other parts deliver
  FaceCollector faces_;
};

}  // namespace

void walk_ply_binary(const PlyReading& reading, std::size_t element, std::uint64_t offset,
                     bool with_vertices) {
  Walker(reading, offset).walk(element, with_vertices);
}

VertexBlock read_vertex_rows(const PlyReading& reading, const PlyElement& element, std::uint64_t offset,
                             std::uint64_t first, std::size_t count, Remarks& remarks) {
  std::vector<std::byte> rows(count * element.row_bytes);
  reading.file.read_at(offset + first * element.row_bytes, rows);
  return convert_vertex_rows(reading.ply.vertex_layout, element, reading.ply.swap, rows, first, count,
                             remarks);
}

}  // namespace colossus::input
