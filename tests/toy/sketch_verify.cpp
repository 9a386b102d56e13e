// What holds for a sketch: bounds, counts, edges and areas as they are stored, and distances to the input.
#include "codec/coded/lattice_node.hpp"
#include "core/error.hpp"
#include "toy/sketch.hpp"
#include "toy/sketch_reader.hpp"
#include "toy/tables.hpp"
#include "verify/measure/census.hpp"
#include "verify/measure/finest.hpp"
#include "verify/measure/input_check.hpp"

namespace colossus::toy {
namespace {

using namespace verify::measure;
using reader::access::RowIndex;
using reader::access::RowRange;

class Verifier {
 public:
  Verifier(const Statue& statue, const VerifyOptions& options)
      : statue_(statue),
        options_(options),
        log_(report_, options.examples_per_kind),
        is_damaged_(statue.rows().size(), false) {}

  VerifyReport run() {
    report_.nodes = statue_.rows().size();
    if (options_.against != nullptr) {
      input_.emplace(statue_, *options_.against);
      input_->compare(log_);
      greatest_.resize(statue_.rows().size());
    }
    check_layout(statue_, log_);
    for (std::uint32_t level = 0; level <= kFinestLevel; ++level) check_level(level);
    check_finest(statue_, finest_, log_);
    log_.check_census(statue_);
    log_.check_orientation(statue_);
    if (input_)
      count_loose(
          statue_, greatest_, is_damaged_,
          [](RowIndex row) { return row == 0 ? std::vector<RowIndex>() : std::vector<RowIndex>{0}; },
          [&](RowIndex) { return statue_.lattice_error(); }, report_, log_);
    log_.sort();
    return std::move(report_);
  }

 private:
  void check_level(std::uint32_t level) {
    log_.start_level(level);
    const RowRange range = statue_.rows_of_level(level);
    report_.levels.back().nodes = range.size();
    for (RowIndex row = range.first; row < range.last; ++row) {
      if (level > 0 && statue_.rows()[row].error > statue_.rows()[0].error)
        log_.add({FindingKind::kErrorGrowth,
                  fmt::format("node at {}: its error is larger than the sketch's", statue_.name(row))});
      try {
        check_node(row, statue_.load(row));
      } catch (const core::Error& error) {
        if (error.status() != core::Status::kBadData) throw;
        log_.add({FindingKind::kDamage, error.what()});
        is_damaged_[row] = true;
        census_.add_damaged(false);
        finest_.is_whole = finest_.is_whole && level < kFinestLevel;
        ++report_.levels.back().damaged_nodes;
      }
    }
    report_cut(census_.finish_level(), report_.levels.back());
    finest_.border_edges = report_.levels.back().border_edges;
    finest_.nonmanifold_edges = report_.levels.back().nonmanifold_edges;
    if (input_) measure_level(level, range);
  }

  void check_node(RowIndex row, const codec::coded::CodedNode& node) {
    const codec::coded::CodedPart& part = node.parts[0];
    std::vector<codec::coded::ScaledPosition> positions;
    std::vector<WorldPoint> points;
    const auto& bounds = statue_.rows()[row].bounds;
    for (const geometry::Point& p : lattice_positions(node)) {
      positions.push_back({p.x, p.y, p.z});
      points.push_back(statue_.world(p));
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (points.back()[axis] < bounds[axis] || points.back()[axis] > bounds[axis + 3])
          log_.add({FindingKind::kBounds,
                    fmt::format("node at {}: a vertex outside its bounds", statue_.name(row))});
    }
    const std::vector<std::uint8_t> may_be_shared(positions.size(), 1);
    PartCensus census = take_census(positions, may_be_shared, part.triangles);
    report_.levels.back().inconsistent_edges += census.inconsistent_edges;
    census_.add(std::move(census), false);
    if (statue_.is_leaf(row)) add_to_finest(row, positions, points, part.triangles);
    if (!input_) return;
    for (WorldPoint& p : points) p = input_->scale().scaled(p);
    const PartMeasure measured = measure_part(*input_, {points, part.triangles}, options_.samples_per_node,
                                              seed_of(statue_.rows()[row], options_.seed));
    report_.samples += measured.samples;
    greatest_[row] = measured.greatest;
    if (auto finding = check_distance(statue_, row, measured.farthest, measured.greatest))
      log_.add(std::move(*finding));
    surface_.add(row, points, part.triangles, false);
  }

  void add_to_finest(RowIndex row, const std::vector<codec::coded::ScaledPosition>& positions,
                     const std::vector<WorldPoint>& points, const std::vector<mesh::Triangle>& triangles) {
    FinestSurface part;
    part.triangles = triangles.size();
    part.greatest_error = statue_.rows()[row].error;
    for (const mesh::Triangle& t : triangles)
      for (const std::uint32_t v : t) part.bounds.add(points[v]);
    add_area(part, positions, triangles, 1.0);
    finest_.add(part);
  }

  void measure_level(std::uint32_t level, const RowRange& range) {
    surface_.finish();
    HeldError held;  // everywhere the level's greatest
    for (RowIndex row = range.first; row < range.last; ++row) consider(statue_, row, is_damaged_, held);
    measure_from_input(
        statue_, *input_, surface_,
        {level, level == kFinestLevel, report_.levels.back().is_partial,
         options_.samples_per_node * range.size(), options_.seed + level},
        [&](const WorldPoint&) { return held; }, log_, greatest_);
    surface_.start_next();
  }

  const Statue& statue_;
  const VerifyOptions& options_;
  VerifyReport report_;
  FindingLog log_;
  std::vector<bool> is_damaged_;
  std::optional<Input> input_;
  LevelSurface surface_;
  LevelCensus census_;
  FinestSurface finest_;
  std::vector<double> greatest_;
};

}  // namespace

VerifyReport verify(const reader::access::Statue& statue, const VerifyOptions& options) {
  return Verifier(dynamic_cast<const Statue&>(statue), options).run();
}

}  // namespace colossus::toy
