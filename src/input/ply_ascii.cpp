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
  explicit AsciiReader(const PlyReading& reading)
      : reading_(reading),
        ply_(reading.ply),
        info_(reading.info),
        text_(reading.file, reading.ply.header.bytes, {}),
        vertices_(reading.info, reading.sink, remarks_),
        faces_(reading.info, reading.sink, remarks_) {}

  void read() {
    for (const PlyElement& element : ply_.header.elements) {
      if (element.properties.empty()) continue;
      const PlyRole role = role_of(element);
      const bool is_face = role == PlyRole::kFace || role == PlyRole::kStrips;
      index_list_ =
          is_face && element.count > 0 ? find_index_list(info_, element, reading_.options.is_lenient) : -1;
      for (row_ = 0; row_ < element.count; ++row_) {
        if (!text_.next_row())
          fail(Status::kBadData, "{}: truncated: expected {} rows of element {}, found {}",
               info_.path.string(), element.count, element.name, row_);
        const std::uint64_t line = text_.line();
        read_row(element, role);
        if (const auto extra = text_.word(); !extra.empty())
          take_surplus(element, role, extra, text_.line() == line);
      }
    }
    vertices_.finish();
    faces_.finish();
    if (text_.next_row())
      check_tail(info_, reading_.options, reading_.file, text_.offset(), remarks_);
    else
      remarks_.trailing_padding = text_.padding();
    reading_.sink.remarks(remarks_);
  }

 private:
  // More words in a row than it should have: the first, and the others. In a row that goes on over several
  // lines they may be those of the next one, because one is missing.
  void take_surplus(const PlyElement& element, PlyRole role, std::string_view extra, bool is_one_line) {
    if (!reading_.options.is_lenient || !parse_double(extra) || !is_one_line) {
      fail(Status::kBadData,
           "{}: {} {}: expected the end of the line after {} properties, found '{}'; --lenient lets surplus "
           "numbers pass",
           info_.path.string(), element.name, row_, element.properties.size(), extra);
    }
    while (!extra.empty()) extra = text_.word();
    (role == PlyRole::kVertex  ? remarks_.surplus_in_vertices
     : role == PlyRole::kOther ? remarks_.surplus_elsewhere
                               : remarks_.surplus_in_faces)
        .add(row_);
  }

  std::string_view take_word(const PlyElement& element, const PlyProperty& property) {
    const std::string_view word = text_.word_of_any_line();
    if (word.empty())
      fail(Status::kBadData, "{}: truncated in {} {}: expected property {}, found the end of the file",
           info_.path.string(), element.name, row_, property.name);
    return word;
  }

  std::int64_t take_int(const PlyElement& element, const PlyProperty& property) {
    const std::string_view word = take_word(element, property);
    if (const auto value = parse_int(word)) return *value;
    const auto value = parse_float_int(word);
    if (!value || !reading_.options.is_lenient)
      fail(Status::kBadData, "{}: {} {}: property {}: expected an integer, found '{}'{}", info_.path.string(),
           element.name, row_, property.name, word, value ? "; --lenient lets it pass" : "");
    has_float_indices_ = true;
    return *value;
  }

  void read_row(const PlyElement& element, PlyRole role) {
    VertexValues values;
    has_float_indices_ = false;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
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
      const int slot = slot_of(role, i);
      if (slot == kUnused) continue;
      const auto value = parse_double(word);
      if (!value)
        fail(Status::kBadData, "{}: {} {}: property {}: expected a number, found '{}'", info_.path.string(),
             element.name, row_, property.name, word);
      set_slot(slot, property.type, *value, values, remarks_);
    }
    if (has_float_indices_) remarks_.float_indices.add(row_);
    end_row(role, values);
  }

  int slot_of(PlyRole role, std::size_t property) const {
    if (role == PlyRole::kVertex) return ply_.vertex_layout.slot[property];
    for (std::size_t k = 0; k < 4 && role == PlyRole::kFace; ++k)
      if (ply_.face_color[k] == static_cast<int>(property)) return static_cast<int>(6 + k);
    return kUnused;
  }

  void end_row(PlyRole role, const VertexValues& values) {
    if (role == PlyRole::kVertex) vertices_.add(values);
    if (role == PlyRole::kStrips) faces_.end_strip();
    if (role != PlyRole::kFace) return;
    faces_.end_polygon(&values);
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
  }

  const PlyReading& reading_;
  const PlyFile& ply_;
  const SourceInfo& info_;
  Remarks remarks_;
  TextReader text_;
  VertexCollector vertices_;
  FaceCollector faces_;
  int index_list_ = -1;
  bool has_float_indices_ = false;  // in this row
  std::uint64_t row_ = 0;
};

}  // namespace

void read_ply_ascii(const PlyReading& reading) { AsciiReader(reading).read(); }

}  // namespace colossus::input
