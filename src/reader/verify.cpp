#include "reader/verify.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "reader/census.hpp"
#include "reader/faces.hpp"
#include "reader/input_samples.hpp"
#include "reader/parallel.hpp"
#include "reader/welded.hpp"

namespace colossus::reader {
namespace {

constexpr std::size_t kBatch = 128;  // nodes in flight

struct NodeReport {
  std::vector<Finding> findings;
  NodeBoundary boundary;
  std::vector<PartCensus> census;
  std::uint64_t samples = 0;
  double greatest_distance = 0.0;
  double greatest_either_way = 0.0;  // also from the input to the node
};

// Rows against each other; needs no geometry.
std::vector<Finding> check_structure(const Statue& statue, RowIndex row) {
  std::vector<Finding> findings;
  const auto add = [&](FindingKind kind, const std::string& message) {
    findings.push_back({kind, fmt::format("node at {}: {}", statue.name(row), message)});
  };
  const container::NodeRow& own = statue.rows()[row];
  for (const RowIndex parent : statue.parents(row)) {
    if (statue.is_leaf(parent) && own.tetra_mask != 0 && !statue.is_leaf(row))
      add(FindingKind::kStructure,
          fmt::format("it is split, but its parent at {} is a leaf", statue.name(parent)));
    // Where a parent is a leaf, the node's other parents made it.
    if (!statue.is_leaf(parent) && statue.rows()[parent].error < own.error)
      add(FindingKind::kErrorGrowth,
          fmt::format("its error {} is larger than {}, that of its parent at {}", own.error,
                      statue.rows()[parent].error, statue.name(parent)));
  }
  bool has_child = false;
  for (std::uint8_t place = 0; place < kMaxPlaces; ++place) {
    const TetrahedronRef ref{row, place};
    if (!statue.has_geometry(ref)) continue;
    if (!statue.exists(ref))
      add(FindingKind::kStructure,
          fmt::format("place {} has geometry, but its parent has no node or is a leaf", place));
    if (statue.is_leaf(row)) continue;
    bool has_half = false;
    for (int end = 0; end < 2; ++end)
      if (const TetrahedronRef half = statue.child(ref, end); half.exists() && statue.has_geometry(half))
        has_half = true;
    if (!has_half)
      add(FindingKind::kStructure,
          fmt::format("place {} has geometry and is split, but neither half has any", place));
    has_child = has_child || has_half;
  }
  if (!statue.is_leaf(row) && !has_child)
    add(FindingKind::kStructure, "it is no leaf, but nothing lies below it");
  if (!statue.is_leaf(row) && (own.flags & container::kNodeIsAboveLimit) != 0)
    add(FindingKind::kStructure, "it is above the leaf limit, but no leaf");
  if (own.tetra_mask == 0) add(FindingKind::kStructure, "it has no tetrahedron");
  return findings;
}

std::optional<std::string> outside_bounds(const Statue& statue, RowIndex row,
                                          const codec::QuantizedTetrahedron& part,
                                          const hierarchy::Tetrahedron& tetrahedron) {
  const auto& bounds = statue.rows()[row].bounds;
  for (std::size_t i = 0; i < part.weights.size(); ++i) {
    const auto p = statue.world(codec::scaled_position(part.weights[i], tetrahedron));
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (p[axis] < bounds[axis] || p[axis] > bounds[axis + 3])
        return fmt::format("vertex {} of place {} at {} {} {} lies outside the bounds {} to {} on axis {}", i,
                           part.place, p[0], p[1], p[2], bounds[axis], bounds[axis + 3], axis);
  }
  return std::nullopt;
}

void measure_node(const Statue& statue, const VerifyOptions& options, RowIndex row, const Node& node,
                  const InputSamples& input_samples, NodeReport& report) {
  std::vector<WorldPoint> points;
  std::vector<mesh::Triangle> triangles;
  for (const auto& part : node.mesh.tetrahedra) {
    const auto base = static_cast<std::uint32_t>(points.size());
    for (const auto& weights : part.weights)
      points.push_back(statue.world(codec::scaled_position(weights, node.diamond.tetrahedra[part.place])));
    for (const mesh::Triangle& t : part.triangles)
      triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
  const auto& center = statue.rows()[row].center;
  const std::uint64_t seed = options.seed ^ geometry::PointHash{}({center[0], center[1], center[2]});
  const std::vector<WorldPoint> samples = sample_surface({points, triangles}, options.samples_per_node, seed);
  WorldPoint farthest{};
  std::uint32_t near = 0;
  for (const WorldPoint& p : samples) {
    const auto found = options.against->nearest(p, near);
    near = found.triangle;
    if (found.distance > report.greatest_distance) {
      report.greatest_distance = found.distance;
      farthest = p;
    }
  }
  report.samples = samples.size();
  report.greatest_either_way = report.greatest_distance;
  // Every vertex, and the other way, only where it can make a difference.
  if (!triangles.empty() && statue.rows()[row].error > kLooseFactor * report.greatest_distance) {
    const SurfaceIndex index({points, triangles});
    std::uint32_t near_in_node = 0;
    for (const std::uint32_t i : input_samples.by_row[row]) {
      const auto found = index.nearest(input_samples.points[i], near_in_node);
      near_in_node = found.triangle;
      report.greatest_either_way = std::max(report.greatest_either_way, found.distance);
    }
    for (const WorldPoint& p : points) {
      const auto found = options.against->nearest(p, near);
      near = found.triangle;
      report.greatest_either_way = std::max(report.greatest_either_way, found.distance);
    }
    report.samples += input_samples.by_row[row].size() + points.size();
  }
  if (auto finding = check_distance(statue, row, farthest, report.greatest_distance))
    report.findings.push_back(std::move(*finding));
}

NodeReport check_node(const Statue& statue, const VerifyOptions& options, const InputSamples& input_samples,
                      RowIndex row) {
  const bool is_closed = statue.count_of("border_edges") == std::uint64_t{0};
  NodeReport report;
  report.findings = check_structure(statue, row);
  const hierarchy::Diamond diamond = hierarchy::Diamond::at(statue.center(row));
  std::array<std::optional<BoundaryChains>, kMaxPlaces> chains;
  std::array<const BoundaryChains*, kMaxPlaces> present{};
  bool is_damaged = false;
  try {
    const Node node = statue.load(row);
    for (const auto& part : node.mesh.tetrahedra) {
      const hierarchy::Tetrahedron& tetrahedron = diamond.tetrahedra[part.place];
      if (const auto outside = outside_bounds(statue, row, part, tetrahedron))
        report.findings.push_back(
            {FindingKind::kBounds, fmt::format("node at {}: {}", statue.name(row), *outside)});
      chains[part.place] = boundary_chains(part, tetrahedron);
      present[part.place] = &*chains[part.place];
      if (is_closed && chains[part.place]->unmarked > 0)
        report.findings.push_back(
            {FindingKind::kFace,
             fmt::format(
                 "node at {}: place {} has {} border edges in faces without marks, but the input is closed",
                 statue.name(row), part.place, chains[part.place]->unmarked)});
      if (statue.exists({row, part.place})) {
        const WeldedTetrahedron welded = weld_positions(part, tetrahedron);
        report.census.push_back(take_census(welded.positions, welded.zero_weights, welded.triangles));
      }
    }
    if (options.against != nullptr) measure_node(statue, options, row, node, input_samples, report);
  } catch (const core::Error& error) {
    if (error.status() != core::Status::kBadData) throw;
    is_damaged = true;
    report.findings.push_back({FindingKind::kDamage, error.what()});
  }
  report.boundary = node_boundary(statue, row, diamond, present, is_damaged);
  return report;
}

class Verifier {
 public:
  Verifier(const Statue& statue, const VerifyOptions& options)
      : statue_(statue), options_(options), log_(report_, options.examples_per_kind) {}

  VerifyReport run() {
    const std::size_t rows = statue_.rows().size();
    report_.nodes = rows;
    if (options_.against != nullptr)
      input_samples_ = sample_input(statue_, options_.against->surface(), options_.seed);
    if (rows == 0) log_.add({FindingKind::kStructure, "the container has no nodes"});
    for (std::size_t begin = 0; begin < rows;) {
      // A batch ends with its level, so that the census can be closed.
      const std::uint32_t level = statue_.rows()[begin].level;
      std::size_t end = begin;
      while (end < rows && end - begin < kBatch && statue_.rows()[end].level == level) ++end;
      if (report_.levels.empty() || report_.levels.back().level != level) {
        if (!report_.levels.empty()) finish_level();
        log_.start_level(level);
      }
      std::vector<NodeReport> batch(end - begin);
      parallel_for(batch.size(), [&](std::size_t i) {
        batch[i] = check_node(statue_, options_, input_samples_, static_cast<RowIndex>(begin + i));
      });
      for (std::size_t i = 0; i < batch.size(); ++i)
        merge(static_cast<RowIndex>(begin + i), std::move(batch[i]));
      begin = end;
    }
    if (!report_.levels.empty()) finish_level();
    finish_boundaries();
    log_.check_census(statue_);
    finish_distances();
    log_.sort();
    return std::move(report_);
  }

 private:
  void finish_level() {
    const EdgeCounts counts = census_.finish_level();
    LevelReport& level = report_.levels.back();
    level.triangles = counts.triangles;
    level.border_edges = counts.border_edges;
    level.nonmanifold_edges = counts.nonmanifold_edges;
  }

  void merge(RowIndex row, NodeReport&& node) {
    ++report_.levels.back().nodes;
    for (Finding& finding : node.findings) log_.add(std::move(finding));
    faces_.insert(faces_.end(), node.boundary.faces.begin(), node.boundary.faces.end());
    std::move(node.boundary.edges.begin(), node.boundary.edges.end(), std::back_inserter(edges_));
    for (PartCensus& census : node.census) census_.add(std::move(census), statue_.is_leaf(row));
    if (node.samples == 0) return;
    report_.samples += node.samples;
    const double error = statue_.rows()[row].error;
    if (error > 0.0)
      report_.greatest_ratio = std::max(report_.greatest_ratio, node.greatest_distance / error);
    sampled_.resize(statue_.rows().size(), 0.0);
    sampled_[row] = node.greatest_either_way;
  }

  void finish_boundaries() {
    BoundaryReport faces = check_faces(statue_, faces_, options_.examples_per_kind);
    report_.faces = faces.faces;
    report_.nonempty_faces = faces.nonempty_faces;
    log_.add_many(FindingKind::kFace, faces.mismatches, std::move(faces.examples));
    BoundaryReport edges = check_edges(statue_, edges_, options_.examples_per_kind);
    report_.edges = edges.faces;
    log_.add_many(FindingKind::kEdge, edges.mismatches, std::move(edges.examples));
  }

  // A node's error is at least that of the nodes below, so it is judged with their distances too.
  void finish_distances() {
    for (auto row = static_cast<RowIndex>(sampled_.size()); row-- > 0;) {
      for (const RowIndex parent : statue_.parents(row))
        if (!statue_.is_leaf(parent)) sampled_[parent] = std::max(sampled_[parent], sampled_[row]);
      const double error = statue_.rows()[row].error;
      if (!(error > statue_.lattice().input_error())) continue;
      ++report_.measured_nodes;
      if (error > std::max(kLooseFactor * sampled_[row], kLooseFactor * weight_unit(row)))
        ++report_.loose_nodes;
    }
    log_.check_looseness();
  }

  // How far one unit of weight moves a vertex of this node at most: on a flat input nothing else is left of
  // an error, and no distance shows it.
  double weight_unit(RowIndex row) const {
    const hierarchy::Diamond diamond = hierarchy::Diamond::at(statue_.center(row));
    return std::sqrt(static_cast<double>(geometry::squared_distance(diamond.ends[0], diamond.ends[1]))) *
           statue_.lattice().step / static_cast<double>(std::int64_t{1} << statue_.metadata().position_bits);
  }

  const Statue& statue_;
  InputSamples input_samples_;
  std::vector<double> sampled_;  // per row, the greatest distance either way
  const VerifyOptions& options_;
  VerifyReport report_;
  FindingLog log_;
  std::vector<FaceEntry> faces_;
  std::vector<EdgeEntry> edges_;
  LevelCensus census_;
};

}  // namespace

VerifyReport verify(const Statue& statue, const VerifyOptions& options) {
  return Verifier(statue, options).run();
}

}  // namespace colossus::reader
