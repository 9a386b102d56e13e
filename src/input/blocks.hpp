// Accumulates vertices and faces one by one into blocks for a sink, with the checks that all formats share.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "input/source.hpp"

namespace colossus::input {

// One vertex as a text or variable-stride format yields it. Colour components are 0 to 255 already.
struct VertexValues {
  std::array<double, 3> position{};
  std::array<double, 3> normal{};
  std::array<std::uint8_t, 4> color{0, 0, 0, 255};
};

// A colour component of 0 to 1 as a byte, rounded and clamped; NaN becomes 0.
std::uint8_t color_from_unit(double value);
// A colour component of 0 to 255 as a byte, rounded and clamped; NaN becomes 0.
std::uint8_t color_from_byte(double value);

// (0, 0, 0) unless all three components are finite as floats.
std::array<float, 3> normal_or_zero(const std::array<double, 3>& normal);

// Throws Error(kBadData): vertex `vertex`'s coordinate `axis` is not finite.
[[noreturn]] void fail_coordinate(const SourceInfo& info, std::uint64_t vertex, int axis, double value);

// Throws Error(kBadData): `element` number `number` names vertex `index`, of `vertex_count`.
[[noreturn]] void fail_index(const SourceInfo& info, std::string_view element, std::uint64_t number,
                             std::int64_t index, std::uint64_t vertex_count);

class VertexCollector {
 public:
  VertexCollector(const SourceInfo& info, BlockSink& sink) : info_(info), sink_(sink) {}
  // Throws Error(kBadData) for a coordinate that is not finite, and for more vertices than 32 bits can
  // number.
  void add(const VertexValues& values);
  // Delivers what is left; to be called once at the end.
  void finish();
  std::uint64_t count() const { return first_ + block_.positions.size(); }

 private:
  const SourceInfo& info_;
  BlockSink& sink_;
  std::uint64_t first_ = 0;
  VertexBlock block_;
};

// Turns the corners of faces and strips into triangles. The caller has checked that the indices are in range.
class FaceCollector {
 public:
  explicit FaceCollector(BlockSink& sink) : sink_(sink) {}

  // A polygon: its corners in order, then end_polygon().
  void polygon_corner(std::uint32_t index) {
    if (corners_ >= 2) add(first_, last_, index);
    if (corners_ == 0) first_ = index;
    last_ = index;
    ++corners_;
  }
  void end_polygon() {
    odd_.polygons += corners_ > 3;
    odd_.small += corners_ < 3;
    corners_ = 0;
  }

  // A triangle strip: every corner after the second makes a triangle, every other one is turned over so that
  // all face the same way. end_strip() at a restart and at the end.
  void strip_corner(std::uint32_t index) {
    if (corners_ >= 2) corners_ % 2 == 0 ? add(first_, last_, index) : add(last_, first_, index);
    first_ = last_;
    last_ = index;
    ++corners_;
  }
  void end_strip() {
    odd_.small += corners_ == 1 || corners_ == 2;
    corners_ = 0;
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    block_.triangles.push_back({a, b, c});
    if (block_.triangles.size() == kBlockElements) flush();
  }
  // Delivers what is left and the odd faces; to be called once at the end.
  void finish();

 private:
  void flush();

  BlockSink& sink_;
  TriangleBlock block_;
  OddFaces odd_;
  std::uint64_t corners_ = 0;
  std::uint32_t first_ = 0;
  std::uint32_t last_ = 0;
};

}  // namespace colossus::input
