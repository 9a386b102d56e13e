// The reader of ASCII PLY files.
#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/ply_source.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

class AsciiReader {
 public:
  AsciiReader(const PlyFile& ply, const SourceInfo& info, BlockSink& sink)
      : ply_(ply), info_(info), text_(ply.file, ply.header.bytes, {}), vertices_(info, sink), faces_(sink) {}

  void read() {
    for (const PlyElement& element : ply_.header.elements) {
      if (element.properties.empty()) continue;
      const PlyRole role = role_of(element);
      const bool is_face = role == PlyRole::kFace || role == PlyRole::kStrips;
      index_list_ = is_face && element.count > 0 ? find_index_list(info_, element) : -1;
      for (row_ = 0; row_ < element.count; ++row_) {
        if (!text_.next_row())
          fail(Status::kBadData, "{}: truncated: expected {} rows of element {}, found {}",
               info_.path.string(), element.count, element.name, row_);
        read_row(element, role);
        if (const auto extra = text_.word(); !extra.empty())
          fail(Status::kBadData, "{}: {} {}: expected the end of the line after {} properties, found '{}'",
               info_.path.string(), element.name, row_, element.properties.size(), extra);
      }
    }
    vertices_.finish();
    faces_.finish();
    if (text_.next_row())
      fail(Status::kBadData, "{}: expected the end of the file after the last element, found '{}'",
           info_.path.string(), text_.word());
  }

 private:
  std::string_view take_word(const PlyElement& element, const PlyProperty& property) {
    const std::string_view word = text_.word_of_any_line();
    if (word.empty())
      fail(Status::kBadData, "{}: truncated in {} {}: expected property {}, found the end of the file",
           info_.path.string(), element.name, row_, property.name);
    return word;
  }

  std::int64_t take_int(const PlyElement& element, const PlyProperty& property) {
    const std::string_view word = take_word(element, property);
    const auto value = parse_int(word);
    if (!value)
      fail(Status::kBadData, "{}: {} {}: property {}: expected an integer, found '{}'", info_.path.string(),
           element.name, row_, property.name, word);
    return *value;
  }

  void read_row(const PlyElement& element, PlyRole role) {
    VertexValues values;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      const int slot = role == PlyRole::kVertex ? ply_.vertex_layout.slot[i] : kUnused;
      if (property.is_list) {
        const std::int64_t count = take_int(element, property);
        check_list_count(info_, element, row_, property, count);
        if (static_cast<int>(i) == index_list_) {
          read_indices(element, property, count, role == PlyRole::kStrips);
        } else {
          for (std::int64_t k = 0; k < count; ++k) take_word(element, property);
        }
        continue;
      }
      const std::string_view word = take_word(element, property);
      if (slot == kUnused) continue;
      const auto value = parse_double(word);
      if (!value)
        fail(Status::kBadData, "{}: {} {}: property {}: expected a number, found '{}'", info_.path.string(),
             element.name, row_, property.name, word);
      set_slot(info_, row_, slot, property.type, *value, values);
    }
    if (role == PlyRole::kVertex) vertices_.add(values);
  }

  void read_indices(const PlyElement& element, const PlyProperty& list, std::int64_t count, bool is_strips) {
    for (std::int64_t k = 0; k < count; ++k) {
      const std::int64_t index = take_int(element, list);
      if (is_strips && index == -1) {
        faces_.end_strip();
        continue;
      }
      if (static_cast<std::uint64_t>(index) >= ply_.vertex_count)
        fail_index(info_, element.name, row_, index, ply_.vertex_count);
      is_strips ? faces_.strip_corner(static_cast<std::uint32_t>(index))
                : faces_.polygon_corner(static_cast<std::uint32_t>(index));
    }
    is_strips ? faces_.end_strip() : faces_.end_polygon();
  }

  const PlyFile& ply_;
  const SourceInfo& info_;
  TextReader text_;
  VertexCollector vertices_;
  FaceCollector faces_;
  int index_list_ = -1;
  std::uint64_t row_ = 0;
};

}  // namespace

void read_ply_ascii(const PlyFile& ply, const SourceInfo& info, BlockSink& sink) {
  AsciiReader(ply, info, sink).read();
}

}  // namespace colossus::input
