// OBJ files (Wavefront): v with optional weight or colours, vn, f; line continuations, negative indices,
// polygons. (Why not OpenMesh: see stl_source.cpp.)
//
// A first pass over the file, when it is opened, counts and decides:
// - Colours (v x y z r g b [a]) if a vertex has them. Four numbers are a position and its weight.
// - Normals if no vertex has two different ones at the corners of its faces; else they are dropped, and
//   listed as skipped: a normal per corner says how the exporter shaded, and normals per vertex can be
//   computed. A vertex that no face with normals uses has an unknown one.
// - Where the data end: at a line that begins with a byte no statement begins with, if no vertex or face
// follows.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
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

// Equal to itself also where it is not a number.
std::array<std::uint32_t, 3> bits_of(const std::array<float, 3>& normal) {
  return std::bit_cast<std::array<std::uint32_t, 3>>(normal);
}

// Distinct unknown statements that are listed; a file that is no OBJ may hold any number.
constexpr std::size_t kMaxListed = 100;
constexpr std::size_t kMostListedBytes = 40;

struct Corner {
  std::int64_t vertex = 0;
  std::int64_t normal = 0;  // 0: none
};

// a, a/b, a//c or a/b/c, where only a must be a number; nothing if it is neither. `parse` takes a number.
template <typename Parse>
std::optional<Corner> parse_corner(std::string_view word, const Parse& parse) {
  std::array<std::int64_t, 3> values{};
  for (int k = 0; k < 3; ++k) {
    const std::size_t slash = std::min(word.find('/'), word.size());
    const std::string_view number = word.substr(0, slash);
    const std::optional<std::int64_t> value = parse(number);
    if (!value && (k == 0 || !number.empty())) return {};
    values[k] = value.value_or(0);
    if (slash == word.size()) return Corner{values[0], values[2]};
    word.remove_prefix(slash + 1);
  }
  return {};
}

// How many numbers a vertex may have, and where its colour begins.
constexpr std::size_t kMostNumbers = 7;
bool has_color(std::size_t numbers) { return numbers >= 6; }

// An OBJ index as one from 0; out of range if it is not below `count`. `seen` is what negative ones count
// back from.
std::uint64_t resolve(std::int64_t index, std::uint64_t seen) {
  return index > 0 ? static_cast<std::uint64_t>(index) - 1 : seen + static_cast<std::uint64_t>(index);
}

// What the first pass finds out.
class Scan {
 public:
  Scan(const core::File& file, bool is_lenient)
      : data_end(file.size()),
        text_(file, 0, {.comments = true, .continuations = true}),
        is_lenient_(is_lenient) {}

  void run() {
    std::optional<std::uint64_t> odd_begin;  // of the lines since the last vertex, normal or face
    std::set<std::string, std::less<>> odd;
    while (text_.next_row()) {
      if (!text_.is_at_text() && !odd_begin) odd_begin = text_.offset();
      const std::string_view keyword = text_.keyword();
      if (keyword == "v" || keyword == "vn" || keyword == "f") {
        odd_begin.reset();
        skipped.merge(odd);
        odd.clear();
      }
      if (odd_begin) {
        list(odd, keyword);
      } else if (keyword == "v") {
        scan_vertex();
      } else if (keyword == "vn") {
        scan_normal();
      } else if (keyword == "f") {
        ++face_count;
        scan_face();
      } else if (keyword == "vt" || keyword == "usemtl" || keyword == "mtllib" || keyword == "maplib" ||
                 keyword == "usemap") {
        list(textures, keyword);
      } else {
        list(skipped, keyword);
      }
    }
    if (odd_begin) data_end = *odd_begin;
  }

  std::uint64_t data_end;
  std::uint64_t vertex_count = 0;
  std::uint64_t face_count = 0;
  std::uint64_t colored_count = 0;  // vertices with colours
  bool has_consistent_normals = true;
  std::vector<std::array<float, 3>> normals;    // NaN where one is not finite
  std::vector<std::uint32_t> normal_of_vertex;  // kNoNormal where no corner has one
  std::set<std::string, std::less<>> textures;
  std::set<std::string, std::less<>> skipped;

 private:
  static void list(std::set<std::string, std::less<>>& names, std::string_view name) {
    name = name.substr(0, kMostListedBytes);
    if (names.size() < kMaxListed && !names.contains(name)) names.emplace(name);
  }

  void scan_vertex() {
    ++vertex_count;
    std::size_t words = 0;
    while (!text_.word().empty()) ++words;
    colored_count += has_color(words);
  }

  void scan_normal() {
    std::array<double, 3> normal;
    for (double& value : normal)
      value = parse_double(text_.word()).value_or(std::numeric_limits<double>::quiet_NaN());
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    if (normals.size() == kNoNormal) return;
    normals.push_back(is_normal(normal) ? normal_or_zero(normal) : std::array<float, 3>{kNan, kNan, kNan});
  }

  void scan_face() {
    for (auto word = text_.word(); !word.empty() && has_consistent_normals; word = text_.word()) {
      const auto corner = parse_corner(word, is_lenient_ ? parse_float_int : parse_int);
      if (!corner || corner->normal == 0) continue;
      const std::uint64_t vertex = resolve(corner->vertex, vertex_count);
      const std::uint64_t normal = resolve(corner->normal, normals.size());
      // References to what follows are legal but not worth an index of their own.
      has_consistent_normals = vertex < vertex_count && normal < normals.size() && vertex_count < kNoNormal;
      if (!has_consistent_normals) return;
      normal_of_vertex.resize(vertex_count, kNoNormal);
      std::uint32_t& known = normal_of_vertex[vertex];
      if (known != kNoNormal && bits_of(normals[known]) != bits_of(normals[normal]))
        has_consistent_normals = false;
      known = static_cast<std::uint32_t>(normal);
    }
  }

  TextReader text_;
  bool is_lenient_;
};

class ObjSource final : public Source {
 public:
  ObjSource(core::File opened, const SourceOptions& options) : Source(std::move(opened), options) {
    info_.format = "OBJ";
    Scan scan(file(), options.is_lenient);
    scan.run();
    data_end_ = scan.data_end;
    info_.vertex_count = scan.vertex_count;
    info_.face_count = scan.face_count;
    info_.textures.assign(scan.textures.begin(), scan.textures.end());
    for (const std::string& keyword : scan.skipped) info_.skipped.push_back(keyword + meaning_of(keyword));
    refuse_textures(info_, options);
    check_vertex_count(info_, info_.vertex_count);
    info_.has_colors = info_.has_both_readings = scan.colored_count > 0;
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
    Reading reading(*this, sink);
    reading.run();
    return true;
  }

 private:
  static const char* meaning_of(std::string_view keyword) {
    if (keyword == "o") return " (names of objects)";
    if (keyword == "g") return " (groups)";
    if (keyword == "s") return " (smoothing groups)";
    if (keyword == "l") return " (lines)";
    if (keyword == "p") return " (points)";
    return "";
  }

  class Reading {
   public:
    Reading(const ObjSource& obj, BlockSink& sink)
        : obj_(obj),
          info_(obj.info_),
          sink_(sink),
          text_(obj.file(), 0, {.comments = true, .continuations = true}),
          vertices_(info_, sink, remarks_),
          faces_(info_, sink, remarks_) {}

    void run() {
      bool is_whole = true;
      while (text_.next_row()) {
        is_whole = text_.offset() < obj_.data_end_;
        if (!is_whole) break;
        const std::string_view keyword = text_.keyword();
        if (keyword == "v") read_vertex();
        if (keyword == "f") read_face();
      }
      vertices_.finish();
      faces_.finish();
      if (is_whole)
        remarks_.trailing_padding = text_.padding();
      else
        check_tail(info_, obj_.options_, obj_.file(), obj_.data_end_, remarks_, text_.line());
      sink_.remarks(remarks_);
    }

   private:
    template <typename... Args>
    [[noreturn]] void bad_vertex(fmt::format_string<Args...> format, Args&&... args) const {
      fail(Status::kBadData, "{}: vertex {} (line {}): {}", info_.path.string(), vertices_.count(),
           text_.line(), fmt::format(format, std::forward<Args>(args)...));
    }

    // The numbers of a row, and how many there are; those that are too many only if they may pass.
    std::size_t read_numbers(std::array<double, kMostNumbers>& numbers) {
      const bool is_lenient = obj_.options_.is_lenient;
      std::size_t count = 0;
      for (auto word = text_.word(); !word.empty(); word = text_.word(), ++count) {
        const auto value = parse_double(word);
        if (!value) bad_vertex("expected a number, found '{}'", word);
        if (count < numbers.size())
          numbers[count] = *value;
        else if (!is_lenient)
          bad_vertex("expected at most {} numbers, found '{}'; --lenient lets surplus numbers pass",
                     numbers.size(), word);
      }
      if (count < 3 || (count == 5 && !is_lenient))
        bad_vertex("expected x y z, x y z w or x y z r g b, found {} numbers", count);
      if (count == 5 || count > numbers.size()) remarks_.surplus_in_vertices.add(vertices_.count());
      return count;
    }

    void read_vertex() {
      std::array<double, kMostNumbers> numbers;
      const std::size_t count = read_numbers(numbers);
      VertexValues values;
      for (std::size_t axis = 0; axis < 3; ++axis)
        values.position[axis] = count == 4 ? numbers[axis] / numbers[3] : numbers[axis];
      values.has_color = has_color(count);
      for (std::size_t k = 0; values.has_color && k + 3 < std::min(count, numbers.size()); ++k)
        values.set_color(k, numbers[3 + k], remarks_);
      const std::uint64_t number = vertices_.count();
      if (info_.has_normals && number < obj_.normal_of_vertex_.size() &&
          obj_.normal_of_vertex_[number] != kNoNormal)
        std::copy_n(obj_.normals_[obj_.normal_of_vertex_[number]].begin(), 3, values.normal.begin());
      vertices_.add(values);
    }

    // Indices are checked against all of the file's vertices: faces may come before them.
    void read_face() {
      const std::uint64_t seen = vertices_.count();
      const std::uint64_t number = face_++;
      bool has_floats = false;
      for (auto word = text_.word(); !word.empty(); word = text_.word()) {
        auto corner = parse_corner(word, parse_int);
        if (!corner && obj_.options_.is_lenient) {
          corner = parse_corner(word, parse_float_int);
          has_floats = true;
        }
        if (!corner)
          fail(Status::kBadData,
               "{}: face {} (line {}): expected a corner like 1, 1/2, 1//3 or 1/2/3, found '{}'{}",
               info_.path.string(), number, text_.line(), word,
               parse_corner(word, parse_float_int) ? "; --lenient lets it pass" : "");
        const std::uint64_t index = resolve(corner->vertex, seen);
        if (corner->vertex == 0 || index >= info_.vertex_count)
          fail(Status::kBadData,
               "{}: face {} (line {}): vertex index {} is out of range; expected 1 to {} or -{} to -1",
               info_.path.string(), number, text_.line(), corner->vertex, info_.vertex_count, seen);
        faces_.polygon_corner(static_cast<std::uint32_t>(index));
      }
      if (has_floats) remarks_.float_indices.add(number);
      faces_.end_polygon();
    }

    const ObjSource& obj_;
    const SourceInfo& info_;
    BlockSink& sink_;
    Remarks remarks_;
    TextReader text_;
    VertexCollector vertices_;
    FaceCollector faces_;
    std::uint64_t face_ = 0;
  };

  std::uint64_t data_end_ = 0;
  std::vector<std::array<float, 3>> normals_;
  std::vector<std::uint32_t> normal_of_vertex_;
};

}  // namespace

constinit const Format kObjFormat{
    "OBJ", ".obj", nullptr,
    [](const FileStart& start) {
      constexpr std::array kWords{"v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"};
      return std::find(kWords.begin(), kWords.end(), start.first_word) != kWords.end();
    },
    [](core::File file, const SourceOptions& options) -> std::unique_ptr<Source> {
      return std::make_unique<ObjSource>(std::move(file), options);
    }};

}  // namespace colossus::input
