// OFF files as Geomview defines them (Geomview manual, "OFF"): [ST][C][N]OFF in ASCII, with comments. (Why
// not OpenMesh: see stl_source.cpp.)
//
//   COFF   # the keyword may be missing, or stand on one line with the counts, even without a space
//   3 1 0  # vertices, faces, edges (not read, and sometimes absent)
//   x y z [nx ny nz] [r g b [a]] [s t]
//   3 0 1 2 [colour of the face]
//
// White space is free between the numbers of vertices; the colour of a face ends with its line, and has 3 or
// 4 numbers, or one that is an index into a table that nobody has. Geomview's vertex colours have 4 numbers,
// those of many others 3. Some write colours, or other numbers, behind vertices without saying so in the
// keyword. So the line of the first vertex decides: if it has as many numbers as a vertex should have, or if
// all lines of vertices have as many as it, then each vertex has a line of its own, and what is surplus there
// can be told.
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

constexpr std::uint64_t kLookedAtLines = 16;

// What the header says.
struct Header {
  std::string keyword;
  std::uint64_t vertex_count = 0;
  std::uint64_t face_count = 0;
  std::uint64_t prose_lines = 0;  // between the keyword and the counts
  bool has_float_counts = false;
};

// How many words are left on the line; of the next one that has any, if there are none.
std::size_t words_of_line(TextReader& text) {
  if (!text.has_word() && !text.next_row()) return 0;
  std::size_t words = 0;
  while (!text.word().empty()) ++words;
  return words;
}

// Whether a row is that of a face: a count, and at least so many words more.
bool is_face_row(TextReader& text) {
  if (!text.next_row()) return false;
  const auto corners = parse_int(text.word());
  std::int64_t words = 0;
  while (!text.word().empty()) ++words;
  return corners && *corners >= 0 && words >= *corners;
}

class HeaderReader {
 public:
  HeaderReader(const SourceInfo& info, const SourceOptions& options, TextReader& text)
      : info_(info), options_(options), text_(text) {}

  // To the first vertex.
  Header read() {
    Header header;
    std::string first = take_keyword(header.keyword);
    if (first == "BINARY") bad("an ASCII file; convert it to PLY", "OFF BINARY");
    while (options_.is_lenient && !header.keyword.empty() && !parse_double(first) && text_.next_row()) {
      ++header.prose_lines;
      first = text_.word();
    }
    header.vertex_count = parse_count(first, header);
    const std::uint64_t line = text_.line();
    header.face_count = parse_count(std::string(text_.word_of_any_line()), header);
    if (has_edge_count(line, header)) text_.word_of_any_line();
    return header;
  }

  [[noreturn]] void bad(std::string_view expected, std::string_view found) const {
    fail(Status::kBadData, "{}: header (line {}): expected {}, found '{}'", info_.path.string(), text_.line(),
         expected, found);
  }

 private:
  // Reads the keyword, if there is one, and returns the first count's word, which may follow it directly.
  std::string take_keyword(std::string& keyword) {
    std::string word(text_.word_of_any_line());
    const std::size_t from = word == "4OFF" ? 1 : 0;
    const std::size_t digits = std::min(word.find_first_of("0123456789", from), word.size());
    keyword = word.substr(0, digits);
    word.erase(0, digits);
    return !word.empty() ? word : std::string(text_.word_of_any_line());
  }

  std::uint64_t parse_count(const std::string& word, Header& header) const {
    auto count = parse_int(word);
    if (!count && options_.is_lenient) {
      count = parse_float_int(word);
      header.has_float_counts = true;
    }
    if (!count || *count < 0) bad("a count of vertices or faces", word);
    return static_cast<std::uint64_t>(*count);
  }

  // Whether the next word is the number of edges. It is missing only if the line of the other counts has no
  // other word, and all lines of vertices, with at least three numbers each, and that of the first face
  // follow.
  bool has_edge_count(std::uint64_t line_of_vertices, const Header& header) const {
    TextReader ahead = text_;
    if (text_.line() != line_of_vertices || ahead.has_word()) return true;
    const std::size_t numbers = words_of_line(ahead);
    if (numbers < 3) return true;
    for (std::uint64_t i = 1; i < header.vertex_count; ++i)
      if (words_of_line(ahead) != numbers) return true;
    return header.face_count > 0 && !is_face_row(ahead);
  }

  const SourceInfo& info_;
  const SourceOptions& options_;
  TextReader& text_;
};

// Which numbers a vertex has, and how they lie.
struct Layout {
  bool is_rows = false;        // each vertex on a line of its own
  std::size_t plain_size = 3;  // position and normal
  std::size_t color_size = 0;
  std::size_t rest_size = 0;  // texture coordinates, or surplus numbers in every row

  std::size_t size() const { return plain_size + color_size + rest_size; }
};

class OffSource final : public Source {
 public:
  OffSource(core::File opened, const SourceOptions& options) : Source(std::move(opened), options) {
    TextReader text = open_text();
    HeaderReader reader(info_, options_, text);
    const Header header = reader.read();
    take_keyword(reader, header);
    info_.vertex_count = header.vertex_count;
    info_.face_count = header.face_count;
    info_.format = fmt::format("{}{}{}OFF", has_texture_ ? "ST" : "", has_color_keyword_ ? "C" : "",
                               info_.has_normals ? "N" : "");
    if (header.prose_lines > 0)
      info_.passed.push_back(
          fmt::format("lines of prose in the header, which --lenient lets pass: {}", header.prose_lines));
    if (header.has_float_counts)
      info_.passed.push_back("floats for counts in the header, which --lenient lets pass");
    if (has_texture_) info_.textures.push_back("vertex.st");
    refuse_textures(info_, options);
    check_vertex_count(info_, info_.vertex_count);
    // Each number takes a character and a separator.
    const std::uint64_t left = info_.bytes;
    if (info_.vertex_count > left / 6 || info_.face_count > left / 2)
      fail(Status::kBadData,
           "{}: truncated, or the header lies: expected {} vertices and {} faces, found {} bytes",
           info_.path.string(), info_.vertex_count, info_.face_count, info_.bytes);
    find_layout(text);
    info_.has_colors = layout_.color_size > 0;
    info_.has_face_colors = !info_.has_colors;
    info_.has_both_readings = true;
  }

  std::vector<Part> parts() const override { return {{PartKind::kWhole, 0, 0}}; }

  bool read(const Part&, BlockSink& sink) const override {
    TextReader text = open_text();
    HeaderReader(info_, options_, text).read();
    Remarks remarks;
    VertexCollector vertices(info_, sink, remarks);
    for (std::uint64_t i = 0; i < info_.vertex_count; ++i) vertices.add(read_vertex(text, i, remarks));
    vertices.finish();
    FaceCollector faces(info_, sink, remarks);
    const bool is_free = are_faces_free(text);
    for (std::uint64_t i = 0; i < info_.face_count; ++i) read_face(text, i, is_free, faces, remarks);
    faces.finish();
    if (text.next_row())
      check_tail(info_, options_, file(), text.offset(), remarks, text.line());
    else
      remarks.trailing_padding = text.padding();
    sink.remarks(remarks);
    return true;
  }

 private:
  TextReader open_text() const { return TextReader(file(), 0, {.comments = true, .continuations = false}); }

  // ST, C and N in any order: where N comes before C, as some write it, normals lie behind the colours.
  void take_keyword(const HeaderReader& reader, const Header& header) {
    std::string keyword = header.keyword;
    for (char& c : keyword)
      if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    std::string_view rest = keyword;
    const auto take = [&](std::string_view prefix, bool& has) {
      if (has || !rest.starts_with(prefix)) return false;
      rest.remove_prefix(prefix.size());
      has = true;
      return true;
    };
    while (take("ST", has_texture_) || take("C", has_color_keyword_) || take("N", info_.has_normals))
      has_normals_last_ = has_normals_last_ || (info_.has_normals && !has_color_keyword_);
    has_normals_last_ = has_normals_last_ && has_color_keyword_;
    if (!keyword.empty() && rest != "OFF")
      reader.bad("OFF, with ST, C and N before it, in three dimensions", header.keyword);
  }

  // From the line of the first vertex, and from the others' where it does not decide.
  void find_layout(const TextReader& text) {
    layout_.plain_size = info_.has_normals ? 6 : 3;
    layout_.rest_size = has_texture_ ? 2 : 0;
    const std::size_t least = layout_.size();
    TextReader ahead = text;
    const std::size_t numbers = words_of_line(ahead);
    const std::size_t expected = least + (has_color_keyword_ ? 4 : 0);
    if (numbers != expected && numbers >= least && are_alike(ahead, numbers))
      return take_surplus(numbers - least);
    if (has_color_keyword_) layout_.color_size = 4;
    layout_.is_rows = numbers >= layout_.size() && are_mostly(text, layout_.size());
  }

  // Whether most of the first lines of vertices have so many numbers.
  bool are_mostly(TextReader text, std::size_t numbers) const {
    const std::uint64_t lines = std::min(info_.vertex_count, kLookedAtLines);
    std::uint64_t alike = 0;
    for (std::uint64_t i = 0; i < lines; ++i) alike += words_of_line(text) == numbers;
    return 2 * alike >= lines;
  }

  // Whether all vertices' lines have so many numbers as the first, which has been read, and as many lines
  // follow as there are faces, the first of which look like faces. Numbers that are wrapped may look like the
  // one or the other.
  bool are_alike(TextReader& text, std::size_t numbers) const {
    for (std::uint64_t i = 1; i < info_.vertex_count; ++i)
      if (words_of_line(text) != numbers) return false;
    for (std::uint64_t i = 0; i < info_.face_count; ++i)
      if (i < kLookedAtLines ? !is_face_row(text) : !text.next_row()) return false;
    return true;
  }

  // So many numbers in all rows that the keyword does not speak of, or too few or many for a colour.
  void take_surplus(std::size_t numbers) {
    layout_.is_rows = true;
    if (numbers == 3 || numbers == 4) {
      layout_.color_size = numbers;
      return;
    }
    layout_.rest_size += numbers;
    info_.skipped.push_back(has_color_keyword_ ? fmt::format("vertex colours of {} numbers", numbers)
                                               : fmt::format("{} more numbers per vertex", numbers));
  }

  [[noreturn]] void fail_word(const TextReader& text, const char* element, std::uint64_t number,
                              std::string_view expected, std::string_view found) const {
    if (found.empty())
      fail(Status::kBadData, "{}: truncated in {} {} (line {}): expected {}, found the end of the file",
           info_.path.string(), element, number, text.line(), expected);
    fail(Status::kBadData, "{}: {} {} (line {}): expected {}, found '{}'", info_.path.string(), element,
         number, text.line(), expected, found);
  }

  double take_number(TextReader& text, std::uint64_t vertex) const {
    const std::string_view word = layout_.is_rows ? text.word() : text.word_of_any_line();
    const auto value = parse_double(word);
    if (!value)
      fail_word(text, "vertex", vertex, "a number",
                word.empty() && text.remaining() > 0 ? "the end of the line" : word);
    return *value;
  }

  VertexValues read_vertex(TextReader& text, std::uint64_t i, Remarks& remarks) const {
    if (layout_.is_rows && !text.has_word()) text.next_row();
    VertexValues values;
    for (double& value : values.position) value = take_number(text, i);
    const auto take_normal = [&] {
      for (double& value : values.normal) value = take_number(text, i);
    };
    if (info_.has_normals && !has_normals_last_) take_normal();
    for (std::size_t k = 0; k < layout_.color_size; ++k) values.set_color(k, take_number(text, i), remarks);
    if (has_normals_last_) take_normal();
    for (std::size_t k = 0; k < layout_.rest_size; ++k) take_number(text, i);
    if (!layout_.is_rows) return values;
    std::string_view extra = text.word();
    if (extra.empty()) return values;
    if (!options_.is_lenient)
      fail(Status::kBadData,
           "{}: vertex {} (line {}): expected the end of the line after {} numbers, found '{}'; --lenient "
           "lets surplus numbers pass",
           info_.path.string(), i, text.line(), layout_.size(), extra);
    while (!extra.empty()) extra = text.word();
    remarks.surplus_in_vertices.add(i);
    return values;
  }

  // A count of corners or an index.
  std::int64_t take_int(TextReader& text, std::uint64_t face, bool& has_floats) const {
    const std::string_view word = text.word_of_any_line();
    if (const auto value = parse_int(word)) return *value;
    const auto value = parse_float_int(word);
    if (value && !options_.is_lenient)
      fail_word(text, "face", face, "an integer (--lenient lets floats pass)", word);
    if (!value) fail_word(text, "face", face, "a number", word);
    has_floats = true;
    return *value;
  }

  // Whether lines do not tell where faces end; these have no colours then.
  bool are_faces_free(TextReader ahead) const {
    if (layout_.is_rows) {
      TextReader rows = ahead;
      std::uint64_t count = 0;
      while (count < info_.face_count && (count < kLookedAtLines ? is_face_row(rows) : rows.next_row()))
        ++count;
      if (count == info_.face_count) return false;
    }
    for (std::uint64_t i = 0; i < info_.face_count; ++i) {
      const auto corners = parse_int(ahead.word_of_any_line());
      if (!corners) return false;
      for (std::int64_t k = 0; k < *corners; ++k)
        if (ahead.word_of_any_line().empty()) return false;
    }
    return !ahead.has_word() && !ahead.next_row();
  }

  void read_face(TextReader& text, std::uint64_t i, bool is_free, FaceCollector& faces,
                 Remarks& remarks) const {
    bool has_floats = false;
    const std::int64_t corners = take_int(text, i, has_floats);
    const std::uint64_t line = text.line();
    if (corners < 0)
      fail(Status::kBadData, "{}: face {}: {} corners; expected at least 0", info_.path.string(), i, corners);
    for (std::int64_t k = 0; k < corners; ++k) {
      const std::int64_t index = take_int(text, i, has_floats);
      if (static_cast<std::uint64_t>(index) >= info_.vertex_count)
        fail_index(info_, "face", i, index, info_.vertex_count);
      faces.polygon_corner(static_cast<std::uint32_t>(index));
    }
    if (has_floats) remarks.float_indices.add(i);
    if (is_free) return faces.end_polygon();
    // Where vertices have lines of their own, a face that goes on over several may do so because a corner is
    // missing: then what belongs to the next one is left over.
    if (layout_.is_rows && text.line() != line && text.has_word())
      fail_word(text, "face", i, fmt::format("{} corners on line {}, or the end of this line", corners, line),
                text.word());
    end_face(text, i, faces, remarks);
  }

  // With the rest of its line, the colour.
  void end_face(TextReader& text, std::uint64_t i, FaceCollector& faces, Remarks& remarks) const {
    std::array<double, 4> numbers{};
    std::size_t count = 0;
    for (auto word = text.word(); !word.empty(); word = text.word(), ++count) {
      const auto value = parse_double(word);
      if (!value) fail_word(text, "face", i, "a number of a colour, or the end of the line", word);
      if (count < numbers.size()) numbers[count] = *value;
    }
    if (count == 2 || count > numbers.size()) {
      if (!options_.is_lenient)
        fail(Status::kBadData,
             "{}: face {} (line {}): expected a colour of 3 or 4 numbers, or the end of the line, found {} "
             "numbers; --lenient lets surplus numbers pass",
             info_.path.string(), i, text.line(), count);
      remarks.surplus_in_faces.add(i);
    }
    remarks.color_indices += count == 1;
    if (count < 3) return faces.end_polygon();
    if (!info_.has_face_colors) {
      ++remarks.unread_colors;
      return faces.end_polygon();
    }
    VertexValues values;
    for (std::size_t k = 0; k < std::min(count, numbers.size()); ++k)
      values.set_color(k, numbers[k], remarks);
    faces.end_polygon(&values);
  }

  bool has_texture_ = false;
  bool has_color_keyword_ = false;
  bool has_normals_last_ = false;  // behind the colours
  Layout layout_;
};

}  // namespace

constinit const Format kOffFormat{
    "OFF", ".off .coff .noff .cnoff", nullptr,
    [](const FileStart& start) {
      const std::string_view word = start.first_word;
      return word.substr(0, word.find_first_of("0123456789", 1)).ends_with("off");
    },
    [](core::File file, const SourceOptions& options) -> std::unique_ptr<Source> {
      return std::make_unique<OffSource>(std::move(file), options);
    }};

}  // namespace colossus::input
