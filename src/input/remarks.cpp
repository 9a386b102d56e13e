#include "input/remarks.hpp"

#include <fmt/core.h>

#include <cmath>

#include "core/error.hpp"
#include "input/source.hpp"

namespace colossus::input {
namespace {

// "3 faces" and "1 face".
std::string count_text(std::uint64_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace

void Remarks::merge(const Remarks& other) {
  polygons += other.polygons;
  small += other.small;
  undefined_positions.merge(other.undefined_positions);
  undefined_normals.merge(other.undefined_normals);
  undefined_colors.merge(other.undefined_colors);
  undefined_alphas.merge(other.undefined_alphas);
  missing_colors.merge(other.missing_colors);
  has_colors = std::max(has_colors, other.has_colors);
  greatest_color = std::max(greatest_color, other.greatest_color);
  greatest_alpha = std::max(greatest_alpha, other.greatest_alpha);
  float_indices.merge(other.float_indices);
  surplus_in_vertices.merge(other.surplus_in_vertices);
  surplus_in_faces.merge(other.surplus_in_faces);
  surplus_elsewhere.merge(other.surplus_elsewhere);
  trailing_bytes += other.trailing_bytes;
  trailing_padding += other.trailing_padding;
  attribute_bytes += other.attribute_bytes;
  solid_names += other.solid_names;
  unread_colors += other.unread_colors;
  color_indices += other.color_indices;
}

void fail_position(const std::filesystem::path& path, std::uint64_t vertex,
                   const std::array<double, 3>& position) {
  std::size_t axis = 0;
  while (axis < 2 && std::isfinite(position[axis])) ++axis;
  core::fail(core::Status::kBadData,
             "{}: vertex {}: coordinate {} is {}; expected a finite number, since a triangle uses it",
             path.string(), vertex, "xyz"[axis], position[axis]);
}

std::vector<std::string> warnings_of(const SourceInfo& info, const Remarks& r) {
  std::vector<std::string> warnings;
  const std::string path = info.path.string();
  for (const std::string& passed : info.passed) warnings.push_back(fmt::format("{}: {}", path, passed));
  const auto say = [&](const Tally& tally, const char* one, const char* many, const char* what) {
    if (tally.count == 0) return;
    warnings.push_back(fmt::format("{}: {} {}, the first is {} {}", path, count_text(tally.count, one, many),
                                   what, one, tally.first));
  };
  const char* const colored = info.has_face_colors ? "face" : "vertex";
  const char* const colored_many = info.has_face_colors ? "faces" : "vertices";
  say(r.undefined_positions, "vertex", "vertices", "without finite coordinates, which no triangle may use");
  say(r.undefined_normals, "vertex", "vertices", "with a normal that is not a number, which is computed");
  say(r.undefined_colors, colored, colored_many, "with a colour that is not a number, which becomes white");
  say(r.undefined_alphas, colored, colored_many, "with an alpha that is not a number, which becomes 255");
  if (r.has_colors != 0)
    say(r.missing_colors, colored, colored_many, "without a colour, where others have one: white");
  say(r.float_indices, "face", "faces", "with floats for indices or counts, let pass by --lenient");
  say(r.surplus_in_vertices, "vertex", "vertices", "with surplus numbers, which --lenient lets pass");
  say(r.surplus_in_faces, "face", "faces", "with surplus numbers, which --lenient lets pass");
  say(r.surplus_elsewhere, "row", "rows",
      "of unread elements with surplus numbers, which --lenient lets pass");
  if (r.trailing_padding > 0)
    warnings.push_back(fmt::format("{}: {} of padding behind the data", path,
                                   count_text(r.trailing_padding, "byte", "bytes")));
  if (r.trailing_bytes > 0)
    warnings.push_back(fmt::format("{}: {} behind the data, which --lenient lets pass", path,
                                   count_text(r.trailing_bytes, "byte", "bytes")));
  return warnings;
}

std::vector<std::string> skipped_by(const Remarks& r) {
  std::vector<std::string> names;
  if (r.attribute_bytes > 0)
    names.push_back(fmt::format("attribute bytes of {} triangles", r.attribute_bytes));
  if (r.solid_names > 0) names.push_back(fmt::format("names of {} solids", r.solid_names));
  if (r.unread_colors > 0) names.push_back(fmt::format("colours of {} faces", r.unread_colors));
  if (r.color_indices > 0)
    names.push_back(
        fmt::format("colours of {} faces, numbers in a table that is not there", r.color_indices));
  return names;
}

}  // namespace colossus::input
