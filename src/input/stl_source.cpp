// STL files, ASCII and binary, with three vertices of its own per triangle: what is equal is welded later, by
// position. Facet normals are not read; they follow from the corners.
//
// Binary files have two bytes per triangle that programs use for colours of 5 bits per component, in two
// ways. VisCAM and SolidView: bit 15 says that there is one, blue lies in the low bits. Magics: the header
// has "COLOR=" with four bytes, the colour of what has none of its own; bit 15 says that a triangle has none,
// red lies in the low bits. Where the header has a colour, 0 counts as none: many write nothing but it, and
// do not mean black.
//
// OpenMesh's reader is not used, for any format: version 9 hands positions to a BaseImporter as floats
// (500000.001 arrives as 500000), passes face indices on unchecked, reports success for truncated files and
// for lines that are no numbers, silently drops vertices that are not finite, and, in STL, degenerate
// triangles; it reads a file as a whole.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/bytes.hpp"
#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/detect_format.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

constexpr std::uint64_t kHeaderBytes = 84;  // 80 of anything and the count
constexpr std::uint64_t kRowBytes = 50;     // normal, three corners, two bytes of anything
constexpr std::uint64_t kPartTriangles = std::uint64_t{1} << 15;
static_assert(3 * kPartTriangles <= kBlockElements);

[[noreturn]] void fail_corner(const SourceInfo& info, std::uint64_t triangle, std::size_t corner,
                              std::size_t axis, double value) {
  fail(Status::kBadData, "{}: triangle {}: coordinate {} of corner {} is {}; expected a finite number",
       info.path.string(), triangle, "xyz"[axis], corner, value);
}

// What the two bytes of triangles mean.
class AttributeColors {
 public:
  explicit AttributeColors(const core::File& file) {
    std::array<std::byte, kHeaderBytes> header;
    file.read_at(0, header);
    const std::string_view text(reinterpret_cast<const char*>(header.data()), kHeaderBytes - 4);
    const std::size_t at = text.find(kMark);
    if (at == std::string_view::npos || at + kMark.size() + 4 > text.size()) return;
    has_header_color_ = true;
    std::memcpy(header_color_.data(), header.data() + at + kMark.size(), 4);
  }

  bool has_header_color() const { return has_header_color_; }

  std::optional<Color> operator()(std::uint16_t attribute) const {
    const bool is_marked = (attribute & 0x8000U) != 0;
    const std::array<std::uint8_t, 3> parts{part(attribute), part(attribute >> 5U), part(attribute >> 10U)};
    if (has_header_color_)
      return is_marked || attribute == 0 ? header_color_ : Color{parts[0], parts[1], parts[2], 255};
    if (!is_marked) return {};
    return Color{parts[2], parts[1], parts[0], 255};
  }

 private:
  static constexpr std::string_view kMark = "COLOR=";
  static std::uint8_t part(unsigned bits) {
    return static_cast<std::uint8_t>(((bits & 31U) * 255 + 15) / 31);
  }

  bool has_header_color_ = false;
  Color header_color_{};
};

// How many triangles the header tells of; 0 for what is too short for one.
std::uint64_t binary_count(const core::File& file) {
  std::array<std::byte, kHeaderBytes> header;
  if (file.read_some_at(0, header) < kHeaderBytes) return 0;
  std::uint32_t count;
  std::memcpy(&count, header.data() + 80, sizeof(count));
  return count;
}

std::uint64_t binary_bytes(std::uint64_t triangles) { return kHeaderBytes + triangles * kRowBytes; }

// A binary STL has the size that its count says, and at most a few bytes or padding more; "solid" at its
// start says nothing.
bool has_size_of_binary(const core::File& file) {
  const std::uint64_t count = binary_count(file);
  const std::uint64_t bytes = binary_bytes(count);
  if (count == 0 || file.size() < bytes) return false;
  return file.size() - bytes < kRowBytes || tail_of(file, bytes).is_padding;
}

class BinaryStl final : public Source {
 public:
  BinaryStl(core::File opened, const SourceOptions& options) : Source(std::move(opened), options) {
    info_.format = "STL binary";
    const std::uint64_t count = binary_count(file());
    if (info_.bytes < kHeaderBytes)
      fail(Status::kBadData, "{}: truncated: expected an STL header of {} bytes, found {}",
           info_.path.string(), kHeaderBytes, info_.bytes);
    check_size(count);
    colors_.emplace(file());
    info_.face_count = count;
    info_.vertex_count = 3 * count;
    info_.has_face_colors = true;
    info_.has_colors = colors_->has_header_color();
    info_.skipped.push_back("facet normals");
    check_vertex_count(info_, info_.vertex_count);
  }

  std::vector<Part> parts() const override {
    std::vector<Part> parts;
    for (std::uint64_t first = 0; first < info_.face_count; first += kPartTriangles)
      parts.push_back({PartKind::kSoup, first, std::min(kPartTriangles, info_.face_count - first)});
    return parts;
  }

  bool read(const Part& part, BlockSink& sink) const override {
    COLOSSUS_CHECK(part.kind == PartKind::kSoup && part.count <= kPartTriangles &&
                   part.first <= info_.face_count && part.count <= info_.face_count - part.first);
    std::vector<std::byte> rows(part.count * kRowBytes);
    file().read_at(kHeaderBytes + part.first * kRowBytes, rows);
    VertexBlock vertices;
    vertices.positions.resize(3 * part.count);
    TriangleBlock triangles;
    triangles.triangles.resize(part.count);
    for (std::size_t i = 0; i < part.count; ++i) {
      std::array<std::array<float, 3>, 3> corners;
      std::memcpy(&corners, rows.data() + i * kRowBytes + 12, sizeof(corners));
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const float value = corners[k][axis];
          if (!std::isfinite(value)) fail_corner(info_, part.first + i, k, axis, value);
          vertices.positions[3 * i + k][axis] = value;
        }
        triangles.triangles[i][k] = static_cast<std::uint32_t>(3 * (part.first + i) + k);
      }
    }
    Remarks remarks;
    vertices.colors = read_colors(part, rows, remarks);
    sink.vertices(3 * part.first, std::move(vertices));
    sink.triangles(std::move(triangles));
    sink.remarks(remarks);
    return true;
  }

 private:
  void check_size(std::uint64_t count) {
    const std::uint64_t expected = binary_bytes(count);
    if (info_.bytes < expected)
      fail(Status::kBadData,
           "{}: truncated in triangle {}: the header says {} triangles; expected {} bytes, found {}",
           info_.path.string(), (info_.bytes - kHeaderBytes) / kRowBytes, count, expected, info_.bytes);
    const std::uint64_t more = info_.bytes - expected;
    if (more == 0) return;
    if (more >= kRowBytes && !(count > 0 && tail_of(file(), expected).is_padding))
      fail(Status::kBadData,
           "{}: the header of this binary STL lies: it says {} triangles; expected {} bytes, found {}, the "
           "size of {} "
           "triangles{}",
           info_.path.string(), count, expected, info_.bytes, (info_.bytes - kHeaderBytes) / kRowBytes,
           (info_.bytes - kHeaderBytes) % kRowBytes == 0 ? "" : " and some bytes more");
    info_.passed.push_back(fmt::format("{} bytes too many behind the last triangle", more));
  }

  // Three per triangle; empty if no triangle of the part has one.
  std::vector<Color> read_colors(const Part& part, std::span<const std::byte> rows, Remarks& remarks) const {
    std::vector<Color> colors(3 * part.count, kNoColor);
    for (std::size_t i = 0; i < part.count; ++i) {
      std::uint16_t attribute;
      std::memcpy(&attribute, rows.data() + i * kRowBytes + 48, sizeof(attribute));
      if (const auto color = (*colors_)(attribute)) {
        std::fill_n(colors.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, *color);
        remarks.has_colors = 1;
      } else {
        remarks.missing_colors.add(part.first + i);
        remarks.attribute_bytes += attribute != 0;
      }
    }
    if (remarks.has_colors == 0) colors.clear();
    return colors;
  }

  std::optional<AttributeColors> colors_;
};

// solid NAME / facet normal X Y Z / outer loop / vertex X Y Z ... / endloop / endfacet / endsolid NAME, any
// number of times, in any case. Line ends matter only after solid and endsolid.
class AsciiStl final : public Source {
 public:
  AsciiStl(core::File opened, const SourceOptions& options) : Source(std::move(opened), options) {
    info_.format = "STL ascii";
    info_.skipped.push_back("facet normals");
  }

  std::vector<Part> parts() const override { return {{PartKind::kWhole, 0, 0}}; }

  bool read(const Part&, BlockSink& sink) const override {
    Reader reader(*this, sink);
    reader.read();
    return true;
  }

 private:
  class Reader {
   public:
    Reader(const AsciiStl& stl, BlockSink& sink)
        : info_(stl.info_),
          sink_(sink),
          text_(stl.file(), 0, {.comments = true, .continuations = false}),
          vertices_(info_, sink, remarks_),
          faces_(info_, sink, remarks_) {}

    void read() {
      while (text_.next_row()) {
        const std::string keyword = lower(text_.keyword());
        expect("solid", keyword.substr(0, 5));
        remarks_.solid_names += text_.has_word() || keyword.size() > 5 ? 1 : 0;
        text_.next_row();
        read_solid();
      }
      vertices_.finish();
      faces_.finish();
      check_vertex_count(info_, vertices_.count());
      remarks_.trailing_padding = text_.padding();
      sink_.remarks(remarks_);
    }

   private:
    static std::string lower(std::string_view word) {
      std::string result(word);
      for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
      return result;
    }
    std::string take() { return lower(text_.word_of_any_line()); }

    void expect(std::string_view expected, std::string_view found) const {
      if (found == expected) return;
      if (found.empty()) found = "the end of the file";
      fail(Status::kBadData, "{}: {}triangle {} (line {}): expected {}, found {}", info_.path.string(),
           text_.remaining() == 0 ? "truncated in " : "", face_, text_.line(), expected, found);
    }

    void read_solid() {
      while (true) {
        const std::string word = take();
        if (word == "endsolid") return;
        expect("facet", word);
        for (std::string_view keyword : {"normal", "x", "y", "z", "outer", "loop"}) {
          const std::string found = take();
          if (keyword.size() > 1 || found.empty()) expect(keyword, found);
        }
        read_loop();
        expect("endfacet", take());
        ++face_;
      }
    }

    void read_loop() {
      std::size_t corner = 0;
      while (true) {
        const std::string word = take();
        if (word == "endloop") break;
        expect("vertex", word);
        VertexValues values;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::string_view number = text_.word_of_any_line();
          const auto parsed = parse_double(number);
          if (!parsed) expect("a number", number);
          if (!std::isfinite(*parsed)) fail_corner(info_, face_, corner, axis, *parsed);
          values.position[axis] = *parsed;
        }
        ++corner;
        faces_.polygon_corner(static_cast<std::uint32_t>(vertices_.count()));
        vertices_.add(values);
      }
      faces_.end_polygon();
    }

    const SourceInfo& info_;
    BlockSink& sink_;
    Remarks remarks_;
    TextReader text_;
    VertexCollector vertices_;
    FaceCollector faces_;
    std::uint64_t face_ = 0;
  };
};

// What begins with "solid" and is not of the size of a binary STL. Floats and counts have zeros, and text has
// none but behind its end.
bool is_text(const core::File& file) {
  constexpr std::size_t kLook = 1000;
  if (has_size_of_binary(file)) return false;
  const FileStart start = start_of(file);
  if (!start.first_word.starts_with("solid")) return false;
  const std::string_view head = std::string_view(start.text).substr(0, kLook);
  return head.substr(0, head.find_last_not_of('\0') + 1).find('\0') == std::string::npos;
}

}  // namespace

constinit const Format kStlFormat{
    "STL", ".stl", [](const FileStart& start) { return has_size_of_binary(start.file); },
    [](const FileStart& start) { return start.first_word.starts_with("solid"); },
    [](core::File file, const SourceOptions& options) -> std::unique_ptr<Source> {
      if (is_text(file)) return std::make_unique<AsciiStl>(std::move(file), options);
      return std::make_unique<BinaryStl>(std::move(file), options);
    }};

}  // namespace colossus::input
