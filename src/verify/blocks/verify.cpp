#include "verify/blocks/verify.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "reader/access/parallel.hpp"
#include "verify/blocks/checks.hpp"
#include "verify/blocks/held_error.hpp"
#include "verify/measure/input_check.hpp"

namespace colossus::verify::blocks {
namespace {

constexpr std::size_t kBatch = 64;                    // nodes in flight
constexpr std::size_t kMostInputSamples = 1'000'000;  // per level
class CubeVerifier {
 public:
  CubeVerifier(const reader::blocks::Statue& statue, const measure::VerifyOptions& options)
      : statue_(statue),
        options_(options),
        log_(report_, options.examples_per_kind),
        is_damaged_(statue.rows().size(), false) {}

  measure::VerifyReport run() {
    report_.nodes = statue_.rows().size();
    if (options_.against != nullptr) {
      input_.emplace(statue_, *options_.against);
      input_->compare(log_);
      sampled_.resize(statue_.rows().size(), 0.0);
    }
    if (report_.nodes == 0) log_.add({measure::FindingKind::kStructure, "the container has no nodes"});
    check_layout(statue_, log_);
    for (std::uint32_t level = 0; report_.nodes > 0 && level <= statue_.deepest_level(); ++level)
      if (const reader::access::RowRange range = statue_.rows_of_level(level); range.size() > 0)
        check_level(level, range);
    check_finest(statue_, finest_, log_);
    log_.check_census(statue_);
    log_.check_orientation(statue_);
    if (input_)
      count_loose(
          statue_, sampled_, is_damaged_, [&](auto row) { return parents(row); },
          [&](auto) { return statue_.lattice_error(); }, report_, log_);
    log_.sort();
    return std::move(report_);
  }

 private:
  void check_level(std::uint32_t level, const reader::access::RowRange& range) {
    log_.start_level(level);
    const LevelFacts facts{greatest_overhang(statue_, level), greatest_overhang(statue_, level + 1),
                           edge_lengths_.mean()};
    edge_lengths_ = {};
    clefts_ = {};
    for (reader::access::RowIndex begin = range.first; begin < range.last;) {
      std::vector<CubeReport> batch(std::min<std::size_t>(kBatch, range.last - begin));
      reader::access::parallel_for(batch.size(), [&](std::size_t i) {
        batch[i] = check_cube(statue_, static_cast<reader::access::RowIndex>(begin + i), facts);
      });
      if (input_) measure_cubes(begin, batch);
      for (std::size_t i = 0; i < batch.size(); ++i)
        merge(static_cast<reader::access::RowIndex>(begin + i), std::move(batch[i]));
      begin += static_cast<reader::access::RowIndex>(batch.size());
    }
    measure::LevelReport& report = report_.levels.back();
    report.nodes = range.size();
    const measure::LevelCounts counts = census_.finish_level();
    report_cut(counts, report);
    if (level == statue_.deepest_level()) {
      finest_.border_edges = counts.cut.border_edges;
      finest_.nonmanifold_edges = counts.cut.nonmanifold_edges;
    }
    if (level < statue_.deepest_level()) report.clefts = clefts_.densities();
    for (measure::Finding& finding : check_shared(statue_, shared_)) log_.add(std::move(finding));
    shared_ = {};
    if (input_) measure_level(level, range);
  }

  void merge(reader::access::RowIndex row, CubeReport&& cube) {
    for (measure::Finding& finding : cube.findings) log_.add(std::move(finding));
    measure::LevelReport& level = report_.levels.back();
    level.inconsistent_edges += cube.census.inconsistent_edges;
    if (cube.is_damaged) {
      is_damaged_[row] = true;
      ++level.damaged_nodes;
      census_.add_damaged(false);
      finest_.is_whole = finest_.is_whole && level.level < statue_.deepest_level();
    }
    census_.add(std::move(cube.census), false);
    finest_.add(cube.finest);
    clefts_.add(cube.clefts);
    edge_lengths_.sum += cube.edge_lengths.sum;
    edge_lengths_.count += cube.edge_lengths.count;
    report_.parents += cube.parents;
    report_.mapped_triangles += cube.mapped_triangles;
    shared_.insert(shared_.end(), cube.shared.begin(), cube.shared.end());
  }

  // Of consecutive rows; keeps their surfaces for the way from the input.
  void measure_cubes(reader::access::RowIndex first, const std::vector<CubeReport>& cubes) {
    std::vector<std::vector<measure::WorldPoint>> points(cubes.size());
    std::vector<measure::PartMeasure> measured(cubes.size());
    reader::access::parallel_for(cubes.size(), [&](std::size_t i) {
      for (const geometry::Point& p : cubes[i].mesh.positions)
        points[i].push_back(input_->scale().scaled(statue_.world(p)));
      measured[i] =
          measure_part(*input_, {points[i], cubes[i].mesh.part().triangles}, options_.samples_per_node,
                       measure::seed_of(statue_.rows()[first + i], options_.seed));
    });
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      const auto row = static_cast<reader::access::RowIndex>(first + i);
      surface_.add(row, points[i], cubes[i].mesh.part().triangles, false);
      report_.samples += measured[i].samples;
      sampled_[row] = measured[i].greatest;
      if (const double error = statue_.rows()[row].error; error > 0.0)
        report_.greatest_ratio = std::max(report_.greatest_ratio, measured[i].greatest / error);
      if (auto finding = measure::check_distance(statue_, row, measured[i].farthest, measured[i].greatest))
        log_.add(std::move(*finding));
    }
  }

  void measure_level(std::uint32_t level, const reader::access::RowRange& range) {
    surface_.finish();
    measure_from_input(
        statue_, *input_, surface_,
        {level, level == statue_.deepest_level(), report_.levels.back().is_partial,
         std::min(kMostInputSamples, options_.samples_per_node * range.size()), options_.seed + level},
        [&](const measure::WorldPoint& p) { return held_error(statue_, level, p, is_damaged_); }, log_,
        sampled_);
    surface_.start_next();
  }

  std::vector<reader::access::RowIndex> parents(reader::access::RowIndex row) const {
    const reader::access::RowIndex parent = statue_.parent(row);
    return parent == reader::access::kNoRow ? std::vector<reader::access::RowIndex>() : std::vector{parent};
  }

  const reader::blocks::Statue& statue_;
  const measure::VerifyOptions& options_;
  measure::VerifyReport report_;
  measure::FindingLog log_;
  measure::LevelCensus census_;
  CleftCounts clefts_;
  EdgeLengths edge_lengths_;          // of the next level
  std::vector<SharedVertex> shared_;  // of the next level
  std::vector<bool> is_damaged_;      // per row, as far as they were decoded
  measure::FinestSurface finest_;
  std::optional<measure::Input> input_;
  measure::LevelSurface surface_;
  std::vector<double> sampled_;  // per row, the greatest distance either way
};

}  // namespace

measure::VerifyReport verify(const reader::blocks::Statue& statue, const measure::VerifyOptions& options) {
  return CubeVerifier(statue, options).run();
}

}  // namespace colossus::verify::blocks
