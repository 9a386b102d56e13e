// STL files, ASCII and binary, with three vertices of its own per triangle: what is equal is welded later, by
// position. Facet normals are not read; they follow from the corners.
//
// OpenMesh's reader is not used, for any format: version 9 hands positions to a BaseImporter as floats
// (500000.001 arrives as 500000), passes face indices on unchecked, reports success for truncated files and
// for lines that are no numbers, silently drops vertices that are not finite, and, in STL, degenerate
// triangles; it reads a file as a whole.
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "core/bytes.hpp"
#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/formats.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

constexpr std::uint64_t kHeaderBytes = 84;  // 80 of anything and the count
constexpr std::uint64_t kRowBytes = 50;     // normal, three corners, two bytes of anything
constexpr std::uint64_t kPartTriangles = std::uint64_t{1} << 15;
static_assert(3 * kPartTriangles <= kBlockElements);

std::uint32_t binary_count(const core::File& file) {
  std::array<std::byte, kHeaderBytes> header;
  if (file.read_some_at(0, header) < kHeaderBytes) return 0;
  std::uint32_t count;
  std::memcpy(&count, header.data() + 80, sizeof(count));
  return count;
}

class BinaryStl final : public Source {
 public:
  explicit BinaryStl(core::File file) : file_(std::move(file)) {
    info_.path = file_.path();
    info_.bytes = file_.size();
    info_.format = "STL binary";
    const std::uint64_t count = binary_count(file_);
    const std::uint64_t expected = kHeaderBytes + count * kRowBytes;
    if (info_.bytes < kHeaderBytes)
      fail(Status::kBadData, "{}: truncated: expected an STL header of {} bytes, found {}",
           info_.path.string(), kHeaderBytes, info_.bytes);
    if (info_.bytes < expected)
      fail(Status::kBadData,
           "{}: truncated in triangle {}: the header says {} triangles; expected {} bytes, found {}",
           info_.path.string(), (info_.bytes - kHeaderBytes) / kRowBytes, count, expected, info_.bytes);
    if (info_.bytes > expected)
      fail(Status::kBadData, "{}: the header lies: it says {} triangles; expected {} bytes, found {}",
           info_.path.string(), count, expected, info_.bytes);
    info_.face_count = count;
    info_.vertex_count = 3 * count;
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
    file_.read_at(kHeaderBytes + part.first * kRowBytes, rows);
    VertexBlock vertices;
    vertices.positions.resize(3 * part.count);
    TriangleBlock triangles;
    triangles.triangles.resize(part.count);
    for (std::size_t i = 0; i < part.count; ++i) {
      std::array<std::array<float, 3>, 3> corners;
      std::memcpy(&corners, rows.data() + i * kRowBytes + 12, sizeof(corners));
      for (std::size_t k = 0; k < 3; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
          const float value = corners[k][axis];
          if (!(std::abs(value) <= std::numeric_limits<float>::max()))
            fail(Status::kBadData,
                 "{}: triangle {}: coordinate {} of corner {} is {}; expected a finite number",
                 info_.path.string(), part.first + i, "xyz"[axis], k, value);
          vertices.positions[3 * i + k][axis] = value;
        }
        triangles.triangles[i][k] = static_cast<std::uint32_t>(3 * (part.first + i) + k);
      }
    }
    sink.vertices(3 * part.first, std::move(vertices));
    sink.triangles(std::move(triangles));
    return true;
  }

 private:
  core::File file_;
};

// solid NAME / facet normal X Y Z / outer loop / vertex X Y Z ... / endloop / endfacet / endsolid NAME, any
// number of times, in any case. Line ends matter only after solid and endsolid.
class AsciiStl final : public Source {
 public:
  explicit AsciiStl(core::File file) : file_(std::move(file)) {
    info_.path = file_.path();
    info_.bytes = file_.size();
    info_.format = "STL ascii";
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
        : info_(stl.info_), text_(stl.file_, 0, {}), vertices_(info_, sink), faces_(sink) {}

    void read() {
      while (text_.next_row()) {
        expect("solid", lower(text_.word()));
        text_.next_row();
        read_solid();
      }
      vertices_.finish();
      faces_.finish();
      check_vertex_count(info_, vertices_.count());
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
      while (true) {
        const std::string word = take();
        if (word == "endloop") break;
        expect("vertex", word);
        VertexValues values;
        for (double& value : values.position) {
          const std::string_view number = text_.word_of_any_line();
          const auto parsed = parse_double(number);
          if (!parsed) expect("a number", number);
          value = *parsed;
        }
        faces_.polygon_corner(static_cast<std::uint32_t>(vertices_.count()));
        vertices_.add(values);
      }
      faces_.end_polygon();
    }

    const SourceInfo& info_;
    TextReader text_;
    VertexCollector vertices_;
    FaceCollector faces_;
    std::uint64_t face_ = 0;
  };

  core::File file_;
};

}  // namespace

bool is_binary_stl(const core::File& file) {
  return file.size() >= kHeaderBytes && file.size() == kHeaderBytes + binary_count(file) * kRowBytes;
}

std::unique_ptr<Source> open_stl(core::File file) {
  std::array<std::byte, 5> start{};
  file.read_some_at(0, start);
  if (std::memcmp(start.data(), "solid", 5) == 0 && !is_binary_stl(file))
    return std::make_unique<AsciiStl>(std::move(file));
  return std::make_unique<BinaryStl>(std::move(file));
}

}  // namespace colossus::input
