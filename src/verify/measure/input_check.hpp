// What verify() of any scheme compares with the input.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "verify/measure/held_error.hpp"
#include "verify/measure/level_surface.hpp"
#include "verify/measure/report.hpp"
#include "verify/measure/scale.hpp"

namespace colossus::verify::measure {

// The input in scaled units. Memory: a copy of the points, and of the triangles where some are left out, and
// an index over it; while it is made some 24 bytes per triangle.
class Input {
 public:
  // `raw` in world units, which must outlive this.
  Input(const reader::access::Statue& statue, const Surface& raw);
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  const Scale& scale() const { return scale_; }
  // Of the whole input.
  const SurfaceIndex& index() const { return index_; }
  // Without degenerate triangles, which have two equal corners.
  Surface kept() const { return {points_, has_degenerate_ ? std::span(kept_) : raw_.triangles}; }

  // Numbers of vertices and triangles, bounds, and area, with what the container says of its input.
  void compare(FindingLog& log) const;

 private:
  std::vector<std::uint32_t> distinct_triangles() const;
  void compare_counts(FindingLog& log) const;
  void compare_bounds(FindingLog& log) const;
  void compare_area(FindingLog& log) const;

  const reader::access::Statue& statue_;
  const Surface raw_;
  const Scale scale_;
  const std::vector<WorldPoint> points_;
  bool has_degenerate_ = false;
  std::vector<mesh::Triangle> kept_;  // only where there are degenerate ones
  const SurfaceIndex index_;
};

// SurfaceIndex::nearest() of p, in scaled units; distances in world units.
SurfaceIndex::Nearest world_distance(const Scale& scale, const SurfaceIndex& index, const WorldPoint& p,
                                     std::uint32_t near, double enough = 0.0);

// From a part of a level to the input: of so many points spread over its surface, which is in scaled units.
struct PartMeasure {
  std::uint64_t samples = 0;
  double greatest = 0.0;  // world units
  WorldPoint farthest{};  // world; where that is
};
PartMeasure measure_part(const Input& input, const Surface& part, std::size_t samples, std::uint64_t seed);
// Points that differ from row to row, and do not depend on the order of rows.
std::uint64_t seed_of(const container::NodeRow& row, std::uint64_t seed);

// From the input to the cut of a level: at the finest one from every triangle of the input, at coarser ones
// from as many points as the level has triangles. So many of these, and not fewer, are measured exactly, and
// all where an error seems to be loose; of the others only that they are near enough, or how far they are.
struct LevelMeasure {
  std::uint32_t level = 0;
  bool is_finest = false;
  bool has_damage = false;  // in the cut
  std::size_t exact_samples = 0;
  std::uint64_t seed = 1;
};
// Adds a finding for each node whose error is exceeded, and what was measured to the level's report;
// greatest[row] becomes at least the distance of each sample that was measured exactly and that the row
// stands for, or is nearest to. `held` says which error holds at a point, in world units; it is called by all
// threads.
void measure_from_input(const reader::access::Statue& statue, const Input& input, const LevelSurface& level,
                        const LevelMeasure& measure, const std::function<HeldError(const WorldPoint&)>& held,
                        FindingLog& log, std::vector<double>& greatest);

// How loose the stored errors are, once all levels are measured: `greatest` holds per row the greatest
// distance either way, and becomes the greatest of it and of all rows below. A node's error is at least that
// of the nodes below, so it is judged with their distances too;
// where one of these is damaged, nothing can be said. `parents` are the rows above one, each with a lesser
// number; `resolution` is what no distance of the row can show, in world units. Completes the report's numbers
// of nodes, and adds a finding where most are loose.
void count_loose(
    const reader::access::Statue& statue, std::vector<double>& greatest, const std::vector<bool>& is_damaged,
    const std::function<std::vector<reader::access::RowIndex>(reader::access::RowIndex)>& parents,
    const std::function<double(reader::access::RowIndex)>& resolution, VerifyReport& report, FindingLog& log);

}  // namespace colossus::verify::measure
