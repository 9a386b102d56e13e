// PLY files: what open_source() decides, and the parts.
//
// A binary file is of fixed stride when all its rows are of known size, under the assumption that every face
// is a triangle, and these sizes add up to the file's. Then vertices and faces are parts that can be read in
// any order; the assumption is checked again by every part. Otherwise the vertices before the first row of
// unknown size are still parts, and the rest is one sequential part. ASCII files are one part.
#include "input/ply_source.hpp"

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/formats.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

bool is_texture_name(const PlyElement& element, std::string_view name) {
  for (const auto& [a, b] : {std::pair{"s", "t"}, {"u", "v"}})
    if ((name == a || name == b) && element.find(a) >= 0 && element.find(b) >= 0) return true;
  return name.starts_with("texture_") || name.starts_with("texcoord") || name.starts_with("tex_coord") ||
         name == "texnumber" || name == "texid";
}

// Whether a property of a face or of tristrips is read.
bool is_face_property(const PlyFile& ply, const SourceInfo& info, const PlyElement& element, int property,
                      bool is_lenient) {
  if (role_of(element) == PlyRole::kFace)
    for (const int color : ply.face_color)
      if (property == color) return true;
  if (element.count > 0) return property == find_index_list(info, element, is_lenient);
  return element.properties[static_cast<std::size_t>(property)].name.starts_with("vertex_ind");
}

// Fills in what is not read: textures and skipped.
void list_unused(const PlyFile& ply, SourceInfo& info, bool is_lenient) {
  for (const std::string& comment : ply.header.texture_comments) info.textures.push_back(comment);
  if (ply.header.has_object_info) info.skipped.push_back("obj_info");
  for (const PlyElement& element : ply.header.elements) {
    const PlyRole role = role_of(element);
    if (role == PlyRole::kOther) {
      (element.name.starts_with("multi_texture") ? info.textures : info.skipped)
          .push_back("element " + element.name);
      continue;
    }
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      const bool is_used = role == PlyRole::kVertex
                               ? ply.vertex_layout.slot[i] != kUnused
                               : is_face_property(ply, info, element, static_cast<int>(i), is_lenient);
      if (is_used) continue;
      (is_texture_name(element, property.name) ? info.textures : info.skipped)
          .push_back(element.name + "." + property.name);
    }
  }
}

// Counts that the file is too short for, however its lists turn out; so that no later arithmetic can
// overflow.
void check_declared_counts(const PlyFile& ply, const SourceInfo& info) {
  const bool is_ascii = ply.header.format == PlyFormat::kAscii;
  // A word of text takes a character and a separator; the last one needs none.
  std::uint64_t left = ply.bytes - ply.header.bytes + (is_ascii ? 1 : 0);
  for (const PlyElement& element : ply.header.elements) {
    const std::uint64_t row = is_ascii ? 2 * element.properties.size() : element.row_bytes;
    if (row == 0) continue;
    if (element.count > left / row)
      fail(Status::kBadData,
           "{}: truncated, or the header lies: expected {} rows of element {} of at least {} bytes each, "
           "found {} bytes",
           info.path.string(), element.count, element.name, row, left);
    left -= element.count * row;
  }
}

class PlySource final : public Source {
 public:
  PlySource(core::File opened, const SourceOptions& options) : Source(std::move(opened), options) {
    ply_.bytes = info_.bytes;
    ply_.header = read_ply_header(file(), options.is_lenient);
    static constexpr const char* kFormats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    info_.format = fmt::format("PLY {}", kFormats[static_cast<int>(ply_.header.format)]);
    if (ply_.header.prose_lines > 0)
      info_.passed.push_back(
          fmt::format("{} header lines without a keyword, the first is line {}, which --lenient lets pass",
                      ply_.header.prose_lines, ply_.header.first_prose_line));
    const PlyElement* vertex = ply_.header.find("vertex");
    if (vertex == nullptr)
      fail(Status::kBadData, "{}: header: expected an element vertex, found none", path());
    ply_.vertex_layout = make_vertex_layout(info_, *vertex);
    ply_.vertex_count = vertex->count;
    ply_.swap = ply_.header.format == PlyFormat::kBigEndian;
    info_.has_normals = ply_.vertex_layout.has_normals;
    info_.vertex_count = vertex->count;
    choose_colors();
    for (const PlyElement& element : ply_.header.elements)
      if (is_face(element)) info_.face_count += element.count;
    list_unused(ply_, info_, options.is_lenient);
    refuse_textures(info_, options);
    check_vertex_count(info_, vertex->count);
    check_declared_counts(ply_, info_);
    if (ply_.header.format != PlyFormat::kAscii) plan_binary();
  }

  std::vector<Part> parts() const override {
    if (!has_vertex_parts_) return {{PartKind::kWhole, 0, 0}};
    std::vector<Part> parts = split(PartKind::kVertices, ply_.vertex_count);
    if (!has_face_parts_) {
      // Not only for its faces: this part also checks that the file ends where it should.
      if (walk_element_ < ply_.header.elements.size()) parts.push_back({PartKind::kAllFaces, 0, 0});
      return parts;
    }
    const auto faces = split(PartKind::kFaces, info_.face_count);
    parts.insert(parts.end(), faces.begin(), faces.end());
    return parts;
  }

  std::vector<Part> sequential_face_parts() const override {
    if (!has_face_parts_) return {};
    return {{PartKind::kAllFaces, 0, 0}};
  }

  bool read(const Part& part, BlockSink& sink) const override {
    const PlyReading reading{ply_, file(), info_, options_, sink};
    switch (part.kind) {
      case PartKind::kVertices: {
        check_part(has_vertex_parts_, part, ply_.vertex_count);
        const PlyElement& element = *ply_.header.find("vertex");
        Remarks remarks;
        sink.vertices(part.first,
                      read_vertex_rows(reading, element, vertex_offset_, part.first, part.count, remarks));
        sink.remarks(remarks);
        return true;
      }
      case PartKind::kFaces:
        check_part(has_face_parts_, part, info_.face_count);
        return read_triangles(reading, part);
      case PartKind::kAllFaces:
        walk_ply_binary(reading, walk_element_, walk_offset_, false);
        return true;
      default:
        if (ply_.header.format == PlyFormat::kAscii) {
          read_ply_ascii(reading);
        } else {
          walk_ply_binary(reading, 0, ply_.header.bytes, true);
        }
        return true;
    }
  }

 private:
  // Those of the vertices, else those of the faces.
  void choose_colors() {
    info_.has_colors = ply_.vertex_layout.has_colors;
    info_.has_both_readings = ply_.vertex_layout.has_float_colors;
    const PlyElement* face = ply_.header.find("face");
    if (info_.has_colors || face == nullptr || face->count == 0) return;
    ply_.face_color = find_color(*face);
    info_.has_face_colors = info_.has_colors = ply_.face_color[0] != kUnused;
    info_.has_both_readings = has_floats(*face, ply_.face_color);
  }

  static bool is_face(const PlyElement& element) {
    const PlyRole role = role_of(element);
    return role == PlyRole::kFace || role == PlyRole::kStrips;
  }
  static bool is_variable(const PlyElement& element) { return element.has_list && element.count > 0; }

  static std::vector<Part> split(PartKind kind, std::uint64_t count) {
    std::vector<Part> parts;
    for (std::uint64_t first = 0; first < count; first += kBlockElements)
      parts.push_back({kind, first, std::min<std::uint64_t>(kBlockElements, count - first)});
    return parts;
  }

  // A part that this file never gave out is a bug of the caller.
  static void check_part(bool is_known, const Part& part, std::uint64_t count) {
    COLOSSUS_CHECK(
        is_known && part.count <= kBlockElements && part.first <= count && part.count <= count - part.first,
        "part {} + {}", part.first, part.count);
  }

  std::string path() const { return info_.path.string(); }

  // Finds out which offsets are known. check_declared_counts() has made sure that rows without lists lie in
  // the file.
  void plan_binary() {
    const auto& elements = ply_.header.elements;
    std::uint64_t offset = ply_.header.bytes;
    std::size_t i = 0;
    for (; i < elements.size() && !is_variable(elements[i]); ++i) {
      if (role_of(elements[i]) == PlyRole::kVertex) set_vertex_offset(offset);
      offset += elements[i].count * elements[i].row_bytes;
    }
    walk_element_ = i;
    walk_offset_ = offset;
    if (i == elements.size()) return check_end(offset);
    if (role_of(elements[i]) == PlyRole::kFace) plan_triangles(elements[i]);
  }

  // What is behind the data where there are no lists.
  void check_end(std::uint64_t offset) {
    Remarks remarks;
    check_tail(info_, options_, file(), offset, remarks);
    for (std::string& warning : warnings_of({}, remarks)) info_.passed.push_back(warning.substr(2));
  }

  // Whether the first list of the file is that of the faces, and three items in every face make the file's
  // size.
  void plan_triangles(const PlyElement& face) {
    triangle_rows_ = make_triangle_rows(face, find_index_list(info_, face, options_.is_lenient),
                                        ply_.face_color, ply_.swap);
    if (!triangle_rows_ || face.count > (ply_.bytes - walk_offset_) / triangle_rows_->stride) return;
    std::uint64_t offset = walk_offset_ + face.count * triangle_rows_->stride;
    std::uint64_t vertex_offset = 0;
    for (std::size_t i = walk_element_ + 1; i < ply_.header.elements.size(); ++i) {
      const PlyElement& element = ply_.header.elements[i];
      if (is_variable(element)) return;
      if (role_of(element) == PlyRole::kVertex) vertex_offset = offset;
      const std::uint64_t left = ply_.bytes - offset;
      if (element.row_bytes > 0 && element.count > left / element.row_bytes) return;
      offset += element.count * element.row_bytes;
    }
    // Vertices behind the faces are where we think even if the faces are not all triangles, but only if the
    // size is exact.
    if (vertex_offset > 0 ? offset != ply_.bytes : !tail_of(file(), offset).is_padding) return;
    if (vertex_offset > 0) set_vertex_offset(vertex_offset);
    has_face_parts_ = true;
    data_end_ = offset;
  }

  void set_vertex_offset(std::uint64_t offset) {
    vertex_offset_ = offset;
    has_vertex_parts_ = true;
  }

  std::vector<std::byte> read_rows(const PlyReading& reading, std::uint64_t first, std::size_t count) const {
    std::vector<std::byte> rows(count * triangle_rows_->stride);
    reading.file.read_at(walk_offset_ + first * triangle_rows_->stride, rows);
    return rows;
  }

  bool read_triangles(const PlyReading& reading, const Part& part) const {
    const std::vector<std::byte> rows = read_rows(reading, part.first, part.count);
    if (!are_all_triangles(*triangle_rows_, rows, part.count)) return false;
    Remarks remarks;
    ConvertedTriangles converted =
        convert_triangle_rows(*triangle_rows_, rows, part.first, part.count, ply_.vertex_count, remarks);
    if (converted.first_bad < part.count) {
      // If a face before this part is no triangle, these rows are not where we think, and this index is none.
      for (std::uint64_t first = 0; first < part.first; first += kBlockElements) {
        const std::size_t count = std::min<std::uint64_t>(kBlockElements, part.first - first);
        if (!are_all_triangles(*triangle_rows_, read_rows(reading, first, count), count)) return false;
      }
      fail_index(info_, "face", part.first + converted.first_bad, converted.bad_index, ply_.vertex_count);
    }
    // If all faces are triangles, this is where the data end.
    if (part.first + part.count == info_.face_count)
      check_tail(info_, options_, reading.file, data_end_, remarks);
    reading.sink.triangles(std::move(converted.block));
    reading.sink.remarks(remarks);
    return true;
  }

  PlyFile ply_;
  bool has_vertex_parts_ = false;
  std::uint64_t vertex_offset_ = 0;
  bool has_face_parts_ = false;  // then the faces begin at walk_offset_
  std::uint64_t data_end_ = 0;   // and this is where the data end, if all of them are triangles
  std::optional<TriangleRows> triangle_rows_;
  std::size_t walk_element_ = 0;  // the first element whose rows have lists, and where it begins
  std::uint64_t walk_offset_ = 0;
};

}  // namespace

void fail_truncated(const SourceInfo& info, const PlyElement& element, std::uint64_t row,
                    std::uint64_t offset, std::uint64_t expected, std::uint64_t found) {
  fail(Status::kBadData, "{}: truncated in {} {} of {}: expected {} bytes at byte {}, found {}",
       info.path.string(), element.name, row, element.count, expected, offset, found);
}

void check_list_count(const SourceInfo& info, const PlyElement& element, std::uint64_t row,
                      const PlyProperty& list, std::int64_t count) {
  if (count < 0)
    fail(Status::kBadData, "{}: {} {}: list {} has count {}; expected at least 0", info.path.string(),
         element.name, row, list.name, count);
}

constinit const Format kPlyFormat{
    "PLY", ".ply",
    [](const FileStart& start) {
      return start.text.size() > 3 && start.text.starts_with("ply") &&
             (start.text[3] == ' ' || (start.text[3] >= '\t' && start.text[3] <= '\r'));
    },
    nullptr,
    [](core::File file, const SourceOptions& options) -> std::unique_ptr<Source> {
      return std::make_unique<PlySource>(std::move(file), options);
    }};

}  // namespace colossus::input
