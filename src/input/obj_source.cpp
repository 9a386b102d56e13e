// OBJ files (Wavefront): v with optional colours, vn, f; line continuations, negative indices, polygons. (Why
// not OpenMesh: see stl_source.cpp.)
//
// A first pass over the file, when it is opened, counts and decides:
// - Colours (v x y z r g b [a]) if every vertex has them; they are 0 to 1, or 0 to 255 if any is greater
// than 1.
// - Normals if no vertex has two different ones at the corners of its faces; else they are dropped, and
// listed as
//   skipped: a normal per corner says how the exporter shaded, and normals per vertex can be computed. A
//   vertex that no face with normals uses has an unknown one.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/formats.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

constexpr std::uint32_t kNoNormal = std::numeric_limits<std::uint32_t>::max();
// Distinct unknown statements that are listed; a file that is no OBJ may hold any number.
constexpr std::size_t kMaxListed = 100;

struct Corner {
  std::int64_t vertex = 0;
  std::int64_t normal = 0;  // 0: none
};

// a, a/b, a//c or a/b/c, where only a must be a number; nothing if it is neither.
std::optional<Corner> parse_corner(std::string_view word) {
  std::array<std::int64_t, 3> values{};
  for (int k = 0; k < 3; ++k) {
    const std::size_t slash = std::min(word.find('/'), word.size());
    const std::string_view number = word.substr(0, slash);
    const auto value = parse_int(number);
    if (!value && (k == 0 || !number.empty())) return {};
    values[k] = value.value_or(0);
    if (slash == word.size()) return Corner{values[0], values[2]};
    word.remove_prefix(slash + 1);
  }
  return {};
}

// An OBJ index as one from 0; out of range if it is not below `count`. `seen` is what negative ones count
// back from.
std::uint64_t resolve(std::int64_t index, std::uint64_t seen) {
  return index > 0 ? static_cast<std::uint64_t>(index) - 1 : seen + static_cast<std::uint64_t>(index);
}

// What the first pass finds out.
class Scan {
 public:
  explicit Scan(const core::File& file) : text_(file, 0, {.comments = true, .continuations = true}) {}

  void run() {
    while (text_.next_row()) {
      const std::string_view keyword = text_.word();
      if (keyword == "v") {
        scan_vertex();
      } else if (keyword == "vn") {
        scan_normal();
      } else if (keyword == "f") {
        ++face_count;
        scan_face();
      } else if (keyword == "vt" || keyword == "usemtl" || keyword == "mtllib" || keyword == "maplib" ||
                 keyword == "usemap") {
        list(textures, keyword);
      } else if (keyword != "o" && keyword != "g" && keyword != "s") {
        list(skipped, keyword);
      }
    }
  }

  std::uint64_t vertex_count = 0;
  std::uint64_t face_count = 0;
  std::uint64_t colored_count = 0;  // vertices with colours
  double largest_color = 0;
  bool has_consistent_normals = true;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::uint32_t> normal_of_vertex;  // kNoNormal where no corner has one
  std::set<std::string, std::less<>> textures;
  std::set<std::string, std::less<>> skipped;

 private:
  static void list(std::set<std::string, std::less<>>& names, std::string_view name) {
    if (names.size() < kMaxListed && !names.contains(name)) names.emplace(name);
  }

  void scan_vertex() {
    ++vertex_count;
    int words = 0;
    for (auto word = text_.word(); !word.empty(); word = text_.word(), ++words)
      if (words >= 3 && words < 7) last_words_[words - 3] = parse_double(word).value_or(0);
    if (words < 6) return;
    ++colored_count;
    for (int k = 0; k < std::min(words - 3, 4); ++k) largest_color = std::max(largest_color, last_words_[k]);
  }

  void scan_normal() {
    std::array<double, 3> normal;
    for (double& value : normal)
      value = parse_double(text_.word()).value_or(std::numeric_limits<double>::quiet_NaN());
    if (normals.size() < kNoNormal) normals.push_back(normal_or_zero(normal));
  }

  void scan_face() {
    for (auto word = text_.word(); !word.empty() && has_consistent_normals; word = text_.word()) {
      const auto corner = parse_corner(word);
      if (!corner || corner->normal == 0) continue;
      const std::uint64_t vertex = resolve(corner->vertex, vertex_count);
      const std::uint64_t normal = resolve(corner->normal, normals.size());
      // References to what follows are legal but not worth an index of their own.
      has_consistent_normals = vertex < vertex_count && normal < normals.size() && vertex_count < kNoNormal;
      if (!has_consistent_normals) return;
      normal_of_vertex.resize(vertex_count, kNoNormal);
      std::uint32_t& known = normal_of_vertex[vertex];
      if (known != kNoNormal && normals[known] != normals[normal]) has_consistent_normals = false;
      known = static_cast<std::uint32_t>(normal);
    }
  }

  TextReader text_;
  std::array<double, 4> last_words_{};
};

class ObjSource final : public Source {
 public:
  ObjSource(core::File file, const SourceOptions& options) : file_(std::move(file)) {
    info_.path = file_.path();
    info_.bytes = file_.size();
    info_.format = "OBJ";
    Scan scan(file_);
    scan.run();
    info_.vertex_count = scan.vertex_count;
    info_.face_count = scan.face_count;
    info_.textures.assign(scan.textures.begin(), scan.textures.end());
    info_.skipped.assign(scan.skipped.begin(), scan.skipped.end());
    refuse_textures(info_, options);
    check_vertex_count(info_, info_.vertex_count);
    info_.has_colors = scan.colored_count == scan.vertex_count;
    if (!info_.has_colors && scan.colored_count > 0)
      info_.skipped.push_back(fmt::format("vertex colours (only {} of {} vertices have them)",
                                          scan.colored_count, scan.vertex_count));
    colors_are_floats_ = scan.largest_color <= 1;
    info_.has_normals = scan.has_consistent_normals && !scan.normal_of_vertex.empty();
    if (info_.has_normals) {
      normals_ = std::move(scan.normals);
      normal_of_vertex_ = std::move(scan.normal_of_vertex);
      normal_of_vertex_.resize(info_.vertex_count, kNoNormal);
    } else if (!scan.normals.empty()) {
      info_.skipped.push_back(scan.has_consistent_normals
                                  ? "vn (normals that no face uses)"
                                  : "vn (normals that differ between the faces of a vertex)");
    }
  }

  std::vector<Part> parts() const override { return {{PartKind::kWhole, 0, 0}}; }

  bool read(const Part&, BlockSink& sink) const override {
    TextReader text(file_, 0, {.comments = true, .continuations = true});
    VertexCollector vertices(info_, sink);
    FaceCollector faces(sink);
    std::uint64_t face = 0;
    while (text.next_row()) {
      const std::string_view keyword = text.word();
      if (keyword == "v") {
        vertices.add(read_vertex(text, vertices.count()));
      } else if (keyword == "f") {
        read_face(text, face++, vertices.count(), faces);
      }
    }
    vertices.finish();
    faces.finish();
    return true;
  }

 private:
  VertexValues read_vertex(TextReader& text, std::uint64_t number) const {
    std::array<double, 7> numbers;
    std::size_t count = 0;
    for (auto word = text.word(); !word.empty(); word = text.word(), ++count) {
      const auto value = parse_double(word);
      if (!value || count == numbers.size())
        fail(Status::kBadData, "{}: vertex {} (line {}): expected {}, found '{}'", info_.path.string(),
             number, text.line(), value ? "at most 7 numbers" : "a number", word);
      numbers[count] = *value;
    }
    if (count < 3 || count == 5)
      fail(Status::kBadData,
           "{}: vertex {} (line {}): expected x y z, x y z w or x y z r g b, found {} numbers",
           info_.path.string(), number, text.line(), count);
    VertexValues values;
    std::copy_n(numbers.begin(), 3, values.position.begin());
    for (std::size_t k = 0; info_.has_colors && k + 3 < count; ++k) {
      if (std::isnan(numbers[3 + k]))
        fail(Status::kBadData, "{}: vertex {} (line {}): colour {} is nan; expected a number",
             info_.path.string(), number, text.line(), k);
      values.color[k] =
          colors_are_floats_ ? color_from_unit(numbers[3 + k]) : color_from_byte(numbers[3 + k]);
    }
    if (info_.has_normals && number < normal_of_vertex_.size() && normal_of_vertex_[number] != kNoNormal)
      std::copy_n(normals_[normal_of_vertex_[number]].begin(), 3, values.normal.begin());
    return values;
  }

  // Indices are checked against all of the file's vertices: faces may come before them.
  void read_face(TextReader& text, std::uint64_t number, std::uint64_t seen, FaceCollector& faces) const {
    for (auto word = text.word(); !word.empty(); word = text.word()) {
      const auto corner = parse_corner(word);
      if (!corner)
        fail(Status::kBadData,
             "{}: face {} (line {}): expected a corner like 1, 1/2, 1//3 or 1/2/3, found '{}'",
             info_.path.string(), number, text.line(), word);
      const std::uint64_t index = resolve(corner->vertex, seen);
      if (corner->vertex == 0 || index >= info_.vertex_count)
        fail(Status::kBadData,
             "{}: face {} (line {}): vertex index {} is out of range; expected 1 to {} or -{} to -1",
             info_.path.string(), number, text.line(), corner->vertex, info_.vertex_count, seen);
      faces.polygon_corner(static_cast<std::uint32_t>(index));
    }
    faces.end_polygon();
  }

  core::File file_;
  bool colors_are_floats_ = true;
  std::vector<std::array<float, 3>> normals_;
  std::vector<std::uint32_t> normal_of_vertex_;
};

}  // namespace

std::unique_ptr<Source> open_obj(core::File file, const SourceOptions& options) {
  return std::make_unique<ObjSource>(std::move(file), options);
}

}  // namespace colossus::input
