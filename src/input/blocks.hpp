// Accumulates vertices and faces one by one into blocks for a sink, with the checks that all formats share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "input/source.hpp"

namespace colossus::input {

// Throws Error(kBadData) when the count is 0, or too large for 32-bit indices.
void check_vertex_count(const SourceInfo& info, std::uint64_t count);

// Throws Error(kBadData) when info.textures is not empty and the options do not drop them.
void refuse_textures(const SourceInfo& info, const SourceOptions& options);

// One vertex as a text or variable-stride format yields it.
struct VertexValues {
  std::array<double, 3> position{};
  std::array<double, 3> normal{};
  ReadColor color;
  bool has_color = true;            // else it is missing where others have one
  bool is_color_undefined = false;  // red, green or blue is not a number
  bool is_alpha_undefined = false;  // then it is 255

  // Component `k` of 0 to 3 of the colour, of unknown scale.
  void set_color(std::size_t k, double value, Remarks& remarks);
};

// Remarks the greatest component `k` of colours of unknown scale.
inline void note_color(std::size_t k, double value, Remarks& remarks) {
  double& greatest = k == 3 ? remarks.greatest_alpha : remarks.greatest_color;
  greatest = std::max(greatest, value);
}

// Whether all three components are finite as floats.
inline bool is_normal(const std::array<double, 3>& n) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::abs(n[0]) <= kMost && std::abs(n[1]) <= kMost && std::abs(n[2]) <= kMost;
}
// (0, 0, 0) unless is_normal().
std::array<float, 3> normal_or_zero(const std::array<double, 3>& normal);

inline bool is_finite(const std::array<double, 3>& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

// Throws Error(kBadData): `element` number `number` names vertex `index`, of `vertex_count`.
[[noreturn]] void fail_index(const SourceInfo& info, std::string_view element, std::uint64_t number,
                             std::int64_t index, std::uint64_t vertex_count);

class VertexCollector {
 public:
  VertexCollector(const SourceInfo& info, BlockSink& sink, Remarks& remarks)
      : info_(info), sink_(sink), remarks_(remarks) {}
  // Throws Error(kBadData) for more vertices than 32 bits can number.
  void add(const VertexValues& values);
  // Delivers what is left; to be called once at the end.
  void finish();
  std::uint64_t count() const { return first_ + block_.positions.size(); }

 private:
  const SourceInfo& info_;
  BlockSink& sink_;
  Remarks& remarks_;
  std::uint64_t first_ = 0;
  VertexBlock block_;
};

// Turns the corners of faces and strips into triangles. The caller has checked that the indices are in range.
class FaceCollector {
 public:
  FaceCollector(const SourceInfo& info, BlockSink& sink, Remarks& remarks)
      : info_(info), sink_(sink), remarks_(remarks) {}

  // A polygon: its corners in order, then end_polygon(). Throws Error(kBadData) for more corners than a
  // block has room for: a fan would be wrong, and nobody could tell.
  void polygon_corner(std::uint32_t index) {
    if (corners_ >= 2) add(first_, last_, index);
    if (corners_ == 0) first_ = index;
    last_ = index;
    ++corners_;
  }
  // The colour is that of `values`, if there are some: white if it is undefined. Without one it is white,
  // too, if others of its block have one.
  void end_polygon(const VertexValues* values = nullptr);

  // A triangle strip: every corner after the second makes a triangle, every other one is turned over so that
  // all face the same way. end_strip() at a restart and at the end.
  void strip_corner(std::uint32_t index) {
    if (corners_ >= 2) {
      corners_ % 2 == 0 ? add(first_, last_, index) : add(last_, first_, index);
      begin_ = block_.triangles.size();  // a strip may be cut by the end of a block
    }
    first_ = last_;
    last_ = index;
    ++corners_;
  }
  void end_strip();

  // Delivers what is left; to be called once at the end.
  void finish();

 private:
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (block_.triangles.size() == kBlockElements) flush();
    block_.triangles.push_back({a, b, c});
  }
  void color_new_triangles(const ReadColor* color);
  void flush();

  const SourceInfo& info_;
  BlockSink& sink_;
  Remarks& remarks_;
  TriangleBlock block_;
  bool has_colors_ = false;  // the block
  std::uint64_t faces_ = 0;  // polygons that have ended
  std::size_t begin_ = 0;    // of the polygon at hand, in the block
  std::uint64_t corners_ = 0;
  std::uint32_t first_ = 0;
  std::uint32_t last_ = 0;
};

}  // namespace colossus::input
