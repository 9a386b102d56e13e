#include "reader/cube_verify.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "reader/cube_checks.hpp"
#include "reader/parallel.hpp"

namespace colossus::reader {
namespace {

constexpr std::size_t kBatch = 64;                    // nodes in flight
constexpr std::size_t kMostInputSamples = 1'000'000;  // per level
constexpr std::size_t kSamplesPerTask = std::size_t{1} << 12;

// All cubes of a level, in world units.
struct LevelSurface {
  std::vector<WorldPoint> points;
  std::vector<mesh::Triangle> triangles;
  std::vector<std::size_t> first_triangles;  // per row of the level

  Surface surface() const { return {points, triangles}; }
};

class CubeVerifier {
 public:
  CubeVerifier(const CubeStatue& statue, const VerifyOptions& options)
      : statue_(statue), options_(options), log_(report_, options.examples_per_kind) {}

  VerifyReport run() {
    report_.nodes = statue_.rows().size();
    if (report_.nodes == 0) log_.add({FindingKind::kStructure, "the container has no nodes"});
    if (options_.against != nullptr) sampled_.resize(statue_.rows().size(), 0.0);
    for (std::uint32_t level = 0; report_.nodes > 0 && level <= statue_.deepest_level(); ++level)
      if (const RowRange range = statue_.rows_of_level(level); range.size() > 0) check_level(level, range);
    log_.check_census(statue_);
    if (options_.against != nullptr) finish_distances();
    log_.sort();
    return std::move(report_);
  }

 private:
  void check_level(std::uint32_t level, const RowRange& range) {
    log_.start_level(level);
    const LevelFacts facts{greatest_overhang(statue_, level), greatest_overhang(statue_, level + 1),
                           edge_lengths_.mean()};
    edge_lengths_ = {};
    clefts_ = {};
    level_ = {};
    for (RowIndex begin = range.first; begin < range.last;) {
      std::vector<CubeReport> batch(std::min<std::size_t>(kBatch, range.last - begin));
      parallel_for(batch.size(), [&](std::size_t i) {
        batch[i] = check_cube(statue_, static_cast<RowIndex>(begin + i), facts);
      });
      for (CubeReport& cube : batch) merge(std::move(cube));
      begin += static_cast<RowIndex>(batch.size());
    }
    LevelReport& report = report_.levels.back();
    report.nodes = range.size();
    const EdgeCounts counts = census_.finish_level();
    report.triangles = counts.triangles;
    report.border_edges = counts.border_edges;
    report.nonmanifold_edges = counts.nonmanifold_edges;
    if (level < statue_.deepest_level()) report.clefts = clefts_.densities();
    for (Finding& finding : check_shared(statue_, shared_)) log_.add(std::move(finding));
    shared_ = {};
    if (options_.against != nullptr) measure_level(range);
  }

  void merge(CubeReport&& cube) {
    for (Finding& finding : cube.findings) log_.add(std::move(finding));
    census_.add(std::move(cube.census), false);
    clefts_.add(cube.clefts);
    edge_lengths_.sum += cube.edge_lengths.sum;
    edge_lengths_.count += cube.edge_lengths.count;
    report_.parents += cube.parents;
    report_.mapped_triangles += cube.mapped_triangles;
    shared_.insert(shared_.end(), cube.shared.begin(), cube.shared.end());
    if (options_.against == nullptr) return;
    const auto base = static_cast<std::uint32_t>(level_.points.size());
    level_.first_triangles.push_back(level_.triangles.size());
    for (const geometry::Point& p : cube.mesh.positions) level_.points.push_back(statue_.world(p));
    for (const mesh::Triangle& t : cube.mesh.triangles)
      level_.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }

  struct Measured {
    std::uint64_t samples = 0;
    double greatest = 0.0;
    WorldPoint farthest{};
  };

  // From the cube of this number within the level to the input.
  Measured measure_cube(const RowRange& range, std::size_t number) const {
    const std::size_t first = level_.first_triangles[number];
    const std::size_t last = number + 1 < level_.first_triangles.size() ? level_.first_triangles[number + 1]
                                                                        : level_.triangles.size();
    Measured measured;
    if (first == last) return measured;
    const auto& center = statue_.rows()[range.first + number].center;
    const Surface cube{level_.points, std::span(level_.triangles).subspan(first, last - first)};
    std::uint32_t near = 0;
    for (const WorldPoint& p :
         sample_surface(cube, options_.samples_per_node,
                        options_.seed ^ geometry::PointHash{}({center[0], center[1], center[2]}))) {
      const auto found = options_.against->nearest(p, near);
      near = found.triangle;
      ++measured.samples;
      if (!(found.distance > measured.greatest)) continue;
      measured.greatest = found.distance;
      measured.farthest = p;
    }
    return measured;
  }

  void measure_level(const RowRange& range) {
    if (level_.triangles.empty()) return;
    std::vector<Measured> cubes(range.size());
    parallel_for(cubes.size(), [&](std::size_t i) { cubes[i] = measure_cube(range, i); });
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      const auto row = static_cast<RowIndex>(range.first + i);
      report_.samples += cubes[i].samples;
      sampled_[row] = cubes[i].greatest;
      if (const double error = statue_.rows()[row].error; error > 0.0)
        report_.greatest_ratio = std::max(report_.greatest_ratio, cubes[i].greatest / error);
      if (auto finding = check_distance(statue_, row, cubes[i].farthest, cubes[i].greatest))
        log_.add(std::move(*finding));
    }
    measure_input(range);
  }

  // From the input to the level: each distance counts for the node that is nearest.
  void measure_input(const RowRange& range) {
    const SurfaceIndex index(level_.surface());
    const std::vector<WorldPoint> samples =
        sample_surface(options_.against->surface(),
                       std::min(kMostInputSamples, options_.samples_per_node * range.size()), options_.seed);
    std::vector<SurfaceIndex::Nearest> found(samples.size());
    parallel_for((samples.size() + kSamplesPerTask - 1) / kSamplesPerTask, [&](std::size_t task) {
      std::uint32_t near = 0;
      for (std::size_t i = task * kSamplesPerTask; i < std::min(samples.size(), (task + 1) * kSamplesPerTask);
           ++i) {
        found[i] = index.nearest(samples[i], near);
        near = found[i].triangle;
      }
    });
    for (const SurfaceIndex::Nearest& nearest : found) {
      const auto after = std::upper_bound(level_.first_triangles.begin(), level_.first_triangles.end(),
                                          std::size_t{nearest.triangle});
      const auto number = static_cast<std::size_t>(after - level_.first_triangles.begin()) - 1;
      double& greatest = sampled_[range.first + number];
      greatest = std::max(greatest, nearest.distance);
    }
    report_.samples += samples.size();
  }

  // A node's error is at least that of the nodes below, so it is judged with their distances too.
  void finish_distances() {
    for (auto row = static_cast<RowIndex>(sampled_.size()); row-- > 0;) {
      if (const RowIndex parent = statue_.parent(row); parent != kNoRow)
        sampled_[parent] = std::max(sampled_[parent], sampled_[row]);
      const double error = statue_.rows()[row].error;
      if (!(error > statue_.lattice_error())) continue;
      ++report_.measured_nodes;
      if (error > kLooseFactor * std::max(sampled_[row], statue_.lattice_error())) ++report_.loose_nodes;
    }
    log_.check_looseness();
  }

  const CubeStatue& statue_;
  const VerifyOptions& options_;
  VerifyReport report_;
  FindingLog log_;
  LevelCensus census_;
  CleftCounts clefts_;
  EdgeLengths edge_lengths_;          // of the next level
  std::vector<SharedVertex> shared_;  // of the next level
  LevelSurface level_;
  std::vector<double> sampled_;  // per row, the greatest distance either way
};

}  // namespace

VerifyReport verify(const CubeStatue& statue, const VerifyOptions& options) {
  return CubeVerifier(statue, options).run();
}

}  // namespace colossus::reader
