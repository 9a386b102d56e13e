#include "input/blocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "input/formats.hpp"

namespace colossus::input {

using core::fail;
using core::Status;

std::uint8_t color_from_byte(double value) {
  if (!(value > 0)) return 0;
  return static_cast<std::uint8_t>(std::min(value, 255.0) + 0.5);
}

std::uint8_t color_from_unit(double value) { return color_from_byte(value * 255); }

std::array<float, 3> normal_or_zero(const std::array<double, 3>& normal) {
  std::array<float, 3> result{};
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(normal[i]) <= std::numeric_limits<float>::max())) return {};
    result[i] = static_cast<float>(normal[i]);
  }
  return result;
}

void fail_coordinate(const SourceInfo& info, std::uint64_t vertex, int axis, double value) {
  fail(Status::kBadData, "{}: vertex {}: coordinate {} is {}; expected a finite number", info.path.string(),
       vertex, "xyz"[axis], value);
}

void fail_index(const SourceInfo& info, std::string_view element, std::uint64_t number, std::int64_t index,
                std::uint64_t vertex_count) {
  fail(Status::kBadData, "{}: {} {}: vertex index {} is out of range; expected 0 to {}", info.path.string(),
       element, number, index, vertex_count - 1);
}

void check_vertex_count(const SourceInfo& info, std::uint64_t count) {
  if (count == 0) fail(Status::kBadData, "{}: has no vertices", info.path.string());
  if (count > std::numeric_limits<std::uint32_t>::max())
    fail(Status::kBadData, "{}: has {} vertices; at most {} are supported per file: split it",
         info.path.string(), count, std::numeric_limits<std::uint32_t>::max());
}

void VertexCollector::add(const VertexValues& values) {
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isfinite(values.position[axis])) fail_coordinate(info_, count(), axis, values.position[axis]);
  block_.positions.push_back(values.position);
  if (info_.has_normals) block_.normals.push_back(normal_or_zero(values.normal));
  if (info_.has_colors) block_.colors.push_back(values.color);
  if (block_.positions.size() == kBlockElements) finish();
}

void VertexCollector::finish() {
  if (block_.positions.empty()) return;
  const std::uint64_t size = block_.positions.size();
  check_vertex_count(info_, first_ + size);
  sink_.vertices(first_, std::exchange(block_, {}));
  first_ += size;
}

void FaceCollector::flush() {
  if (!block_.triangles.empty()) sink_.triangles(std::exchange(block_, {}));
}

void FaceCollector::finish() {
  flush();
  if (odd_.polygons + odd_.small > 0) sink_.odd_faces(odd_);
}

}  // namespace colossus::input
