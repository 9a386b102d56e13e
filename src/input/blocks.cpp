#include "input/blocks.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"

namespace colossus::input {

using core::fail;
using core::Status;

void VertexValues::set_color(std::size_t k, double value, Remarks& remarks) {
  if (std::isnan(value)) {
    (k == 3 ? is_alpha_undefined : is_color_undefined) = true;
    return;
  }
  color.set(k, value);
  note_color(k, value, remarks);
}

std::array<float, 3> normal_or_zero(const std::array<double, 3>& normal) {
  if (!is_normal(normal)) return {};
  return {static_cast<float>(normal[0]), static_cast<float>(normal[1]), static_cast<float>(normal[2])};
}

void fail_index(const SourceInfo& info, std::string_view element, std::uint64_t number, std::int64_t index,
                std::uint64_t vertex_count) {
  fail(Status::kBadData, "{}: {} {}: vertex index {} is out of range; expected 0 to {}", info.path.string(),
       element, number, index, vertex_count - 1);
}

void check_vertex_count(const SourceInfo& info, std::uint64_t count) {
  if (count == 0) fail(Status::kBadData, "{}: has no vertices", info.path.string());
  if (count > std::numeric_limits<std::uint32_t>::max())
    fail(Status::kBadData, "{}: has {} vertices; at most {} (2^32 - 1) are supported per file: split it",
         info.path.string(), count, std::numeric_limits<std::uint32_t>::max());
}

void refuse_textures(const SourceInfo& info, const SourceOptions& options) {
  if (info.textures.empty() || options.drop_textures) return;
  fail(Status::kBadData,
       "{}: has texture coordinates or materials ({}), which cannot be kept; transfer them to vertex "
       "colours, or drop them with --drop-textures",
       info.path.string(), fmt::join(info.textures, ", "));
}

void VertexCollector::add(const VertexValues& values) {
  if (!is_finite(values.position)) remarks_.undefined_positions.add(count());
  if (info_.has_normals) {
    if (!is_normal(values.normal)) remarks_.undefined_normals.add(count());
    block_.normals.push_back(normal_or_zero(values.normal));
  }
  if (info_.has_colors && !info_.has_face_colors) {
    remarks_.has_colors = 1;
    if (values.is_color_undefined) remarks_.undefined_colors.add(count());
    if (values.is_alpha_undefined) remarks_.undefined_alphas.add(count());
    if (!values.has_color) remarks_.missing_colors.add(count());
    const ReadColor color = values.is_color_undefined || !values.has_color ? ReadColor{} : values.color;
    block_.colors.push_back(color.unit);
    if (info_.has_both_readings) block_.byte_colors.push_back(color.byte);
  }
  block_.positions.push_back(values.position);
  if (block_.positions.size() == kBlockElements) finish();
}

void VertexCollector::finish() {
  if (block_.positions.empty()) return;
  const std::uint64_t size = block_.positions.size();
  check_vertex_count(info_, first_ + size);
  sink_.vertices(first_, std::exchange(block_, {}));
  first_ += size;
}

void FaceCollector::color_new_triangles(const ReadColor* color) {
  if (!info_.has_face_colors) return;
  has_colors_ = has_colors_ || color != nullptr;
  block_.colors.resize(block_.triangles.size(), color != nullptr ? color->unit : kNoColor);
  if (info_.has_both_readings)
    block_.byte_colors.resize(block_.triangles.size(), color != nullptr ? color->byte : kNoColor);
}

void FaceCollector::end_polygon(const VertexValues* values) {
  remarks_.polygons += corners_ > 3;
  remarks_.small += corners_ < 3;
  const bool is_undefined = values != nullptr && values->is_color_undefined;
  if (info_.has_face_colors && values == nullptr) remarks_.missing_colors.add(faces_);
  if (info_.has_face_colors && is_undefined) remarks_.undefined_colors.add(faces_);
  if (info_.has_face_colors && values != nullptr && values->is_alpha_undefined)
    remarks_.undefined_alphas.add(faces_);
  if (corners_ > 3)
    block_.polygons.push_back({static_cast<std::uint32_t>(begin_), static_cast<std::uint32_t>(corners_)});
  const ReadColor white;
  color_new_triangles(values == nullptr ? nullptr : is_undefined ? &white : &values->color);
  begin_ = block_.triangles.size();
  corners_ = 0;
  ++faces_;
}

void FaceCollector::end_strip() {
  color_new_triangles(nullptr);
  begin_ = block_.triangles.size();
  remarks_.small += corners_ == 1 || corners_ == 2;
  corners_ = 0;
}

// Delivers all triangles of the block but those of the polygon at hand.
void FaceCollector::flush() {
  if (begin_ == 0)
    fail(Status::kBadData, "{}: face {}: has more than {} corners, too many to be triangulated: cut it",
         info_.path.string(), faces_, block_.triangles.size() + 2);
  TriangleBlock rest;
  const auto begin = static_cast<std::ptrdiff_t>(begin_);
  rest.triangles.assign(block_.triangles.begin() + begin, block_.triangles.end());
  block_.triangles.resize(begin_);
  color_new_triangles(nullptr);  // of a strip
  if (has_colors_) {
    remarks_.has_colors = 1;
  } else {
    block_.colors.clear();
    block_.byte_colors.clear();
  }
  has_colors_ = false;
  sink_.triangles(std::exchange(block_, std::move(rest)));
  begin_ = 0;
}

void FaceCollector::finish() {
  begin_ = block_.triangles.size();
  if (begin_ > 0) flush();
}

}  // namespace colossus::input
