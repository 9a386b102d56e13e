// OFF files (Geomview): [ST][C][N]OFF in ASCII, with comments. One row per line. (Why not OpenMesh: see
// stl_source.cpp.)
//
//   COFF   # the keyword may be missing, or stand on one line with the counts, even without a space
//   3 1 0  # vertices, faces, edges (not read)
//   x y z [nx ny nz] [r g b [a]] [s t]
//   3 0 1 2 [colour of the face, not read]
//
// Colours are floats from 0 to 1 if any of the file's has a point or an exponent, or if none is greater than
// 1; else they are 0 to 255. So one pass over the vertices precedes the first part of a file with colours.
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/formats.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

class OffSource final : public Source {
 public:
  OffSource(core::File file, const SourceOptions& options) : file_(std::move(file)) {
    info_.path = file_.path();
    info_.bytes = file_.size();
    TextReader text = open_text();
    read_header(text);
    info_.format = fmt::format("{}{}{}OFF", has_texture_ ? "ST" : "", info_.has_colors ? "C" : "",
                               info_.has_normals ? "N" : "");
    if (has_texture_) info_.textures.push_back("vertex.st");
    refuse_textures(info_, options);
    // Each number takes a character and a separator.
    const std::uint64_t left = info_.bytes;
    if (info_.vertex_count > left / 6 || info_.face_count > left / 2)
      fail(Status::kBadData,
           "{}: truncated, or the header lies: expected {} vertices and {} faces, found {} bytes",
           info_.path.string(), info_.vertex_count, info_.face_count, info_.bytes);
    check_vertex_count(info_, info_.vertex_count);
    scan_vertices(text);
  }

  std::vector<Part> parts() const override { return {{PartKind::kWhole, 0, 0}}; }

  bool read(const Part&, BlockSink& sink) const override {
    TextReader text = open_text();
    skip_header(text);
    VertexCollector vertices(info_, sink);
    for (std::uint64_t i = 0; i < info_.vertex_count; ++i) vertices.add(read_vertex(text, i));
    vertices.finish();
    FaceCollector faces(sink);
    for (std::uint64_t i = 0; i < info_.face_count; ++i) read_face(text, i, faces);
    faces.finish();
    if (text.next_row())
      fail(Status::kBadData, "{}: line {}: expected the end of the file after {} faces, found '{}'",
           info_.path.string(), text.line(), info_.face_count, text.word());
    return true;
  }

 private:
  TextReader open_text() const { return TextReader(file_, 0, {.comments = true, .continuations = false}); }

  [[noreturn]] void bad_header(const TextReader& text, std::string_view expected,
                               std::string_view found) const {
    fail(Status::kBadData, "{}: header (line {}): expected {}, found '{}'", info_.path.string(), text.line(),
         expected, found);
  }

  // Reads the keyword, if there is one, and returns the first count's word, which may follow it directly.
  static std::string take_keyword(TextReader& text, std::string& keyword) {
    std::string word(text.word_of_any_line());
    const std::size_t from = word == "4OFF" ? 1 : 0;
    const std::size_t digits = std::min(word.find_first_of("0123456789", from), word.size());
    keyword = word.substr(0, digits);
    word.erase(0, digits);
    return !word.empty() ? word : std::string(text.word_of_any_line());
  }

  static void skip_header(TextReader& text) {
    std::string keyword;
    take_keyword(text, keyword);
    text.word_of_any_line();
  }

  void read_header(TextReader& text) {
    std::string keyword;
    const std::string first = take_keyword(text, keyword);
    std::string_view rest = keyword;
    const auto take = [&](std::string_view prefix) {
      if (!rest.starts_with(prefix)) return false;
      rest.remove_prefix(prefix.size());
      return true;
    };
    has_texture_ = take("ST");
    info_.has_colors = take("C");
    info_.has_normals = take("N");
    if (!keyword.empty() && rest != "OFF")
      bad_header(text, "OFF, with ST, C and N before it, in three dimensions", keyword);
    if (first == "BINARY") bad_header(text, "an ASCII file; convert it to PLY", "OFF BINARY");
    info_.vertex_count = parse_count(text, first);
    info_.face_count = parse_count(text, std::string(text.word_of_any_line()));
  }

  std::uint64_t parse_count(const TextReader& text, const std::string& word) const {
    const auto count = parse_int(word);
    if (!count || *count < 0) bad_header(text, "a count of vertices or faces", word);
    return static_cast<std::uint64_t>(*count);
  }

  // How many numbers a colour has (as in the first row), and of which kind they are.
  void scan_vertices(TextReader& text) {
    if (!info_.has_colors) return;
    const std::size_t before = info_.has_normals ? 6 : 3;
    double largest = 0;
    for (std::uint64_t i = 0; i < info_.vertex_count && text.next_row(); ++i) {
      std::array<std::string, 4> colors;
      std::size_t words = 0;
      for (auto word = text.word(); !word.empty(); word = text.word(), ++words)
        if (words >= before && words < before + 4) colors[words - before] = word;
      if (i == 0) color_size_ = color_size(words - std::min(words, before + (has_texture_ ? 2 : 0)));
      for (int k = 0; k < color_size_; ++k) {
        largest = std::max(largest, parse_double(colors[k]).value_or(0));
        colors_are_floats_ |= colors[k].find_first_of(".eE") != std::string::npos;
      }
    }
    colors_are_floats_ |= largest <= 1;
    info_.has_colors = color_size_ > 0;
  }

  int color_size(std::size_t numbers) {
    if (numbers >= 3) return numbers >= 4 ? 4 : 3;
    info_.skipped.push_back(fmt::format("vertex colours of {} numbers", numbers));
    return 0;
  }

  void next_row(TextReader& text, const char* element, std::uint64_t number, std::uint64_t count) const {
    if (!text.next_row())
      fail(Status::kBadData, "{}: truncated: expected {} {} rows, found {}", info_.path.string(), count,
           element, number);
  }

  template <typename Parse>
  auto take_number(TextReader& text, const char* element, std::uint64_t number, const Parse& parse) const {
    const std::string_view word = text.word();
    const auto value = parse(word);
    if (!value)
      fail(Status::kBadData, "{}: {} {} (line {}): expected a number, found '{}'", info_.path.string(),
           element, number, text.line(), word.empty() ? "the end of the line" : word);
    return *value;
  }

  VertexValues read_vertex(TextReader& text, std::uint64_t i) const {
    next_row(text, "vertex", i, info_.vertex_count);
    VertexValues values;
    for (double& value : values.position) value = take_number(text, "vertex", i, parse_double);
    for (int k = 0; k < 3 && info_.has_normals; ++k)
      values.normal[k] = take_number(text, "vertex", i, parse_double);
    for (int k = 0; k < color_size_; ++k) {
      const double value = take_number(text, "vertex", i, parse_double);
      if (value != value)
        fail(Status::kBadData, "{}: vertex {}: colour {} is nan; expected a number", info_.path.string(), i,
             k);
      values.color[k] = colors_are_floats_ ? color_from_unit(value) : color_from_byte(value);
    }
    return values;
  }

  void read_face(TextReader& text, std::uint64_t i, FaceCollector& faces) const {
    next_row(text, "face", i, info_.face_count);
    const std::int64_t corners = take_number(text, "face", i, parse_int);
    if (corners < 0)
      fail(Status::kBadData, "{}: face {}: {} corners; expected at least 0", info_.path.string(), i, corners);
    for (std::int64_t k = 0; k < corners; ++k) {
      const std::int64_t index = take_number(text, "face", i, parse_int);
      if (static_cast<std::uint64_t>(index) >= info_.vertex_count)
        fail_index(info_, "face", i, index, info_.vertex_count);
      faces.polygon_corner(static_cast<std::uint32_t>(index));
    }
    faces.end_polygon();
  }

  core::File file_;
  bool has_texture_ = false;
  int color_size_ = 0;
  bool colors_are_floats_ = false;
};

}  // namespace

std::unique_ptr<Source> open_off(core::File file, const SourceOptions& options) {
  return std::make_unique<OffSource>(std::move(file), options);
}

}  // namespace colossus::input
