#include "verify/diamonds/verify.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "reader/access/parallel.hpp"
#include "reader/diamonds/welded.hpp"
#include "verify/diamonds/faces.hpp"
#include "verify/diamonds/held_error.hpp"
#include "verify/measure/census.hpp"
#include "verify/measure/finest.hpp"
#include "verify/measure/input_check.hpp"

namespace colossus::verify::diamonds {
namespace {

constexpr std::size_t kBatch = 128;  // nodes in flight
// Of the way from the input this share of samples_per_node is measured exactly, up to so many per level.
constexpr std::size_t kInputShare = 16;
constexpr std::size_t kMostInputSamples = 1'000'000;
constexpr std::size_t kMostLooseVertices = 2'000'000;

struct NodeReport {
  std::vector<measure::Finding> findings;
  NodeBoundary boundary;
  std::vector<measure::PartCensus> census;
  std::uint64_t samples = 0;
  double greatest_distance = 0.0;
  double greatest_of_vertices = 0.0;  // as well
  std::uint64_t inconsistent_edges = 0;
  bool is_damaged = false;
  measure::FinestSurface finest;  // of a leaf
  // With the input only; in scaled units:
  std::vector<measure::WorldPoint> points;
  std::vector<mesh::Triangle> triangles;
};

// Rows against each other; needs no geometry.
std::vector<measure::Finding> check_structure(const reader::diamonds::Statue& statue,
                                              reader::access::RowIndex row) {
  std::vector<measure::Finding> findings;
  const auto add = [&](measure::FindingKind kind, const std::string& message) {
    findings.push_back({kind, fmt::format("node at {}: {}", statue.name(row), message)});
  };
  const container::NodeRow& own = statue.rows()[row];
  for (const reader::access::RowIndex parent : statue.parents(row)) {
    if (statue.is_leaf(parent) && own.tetra_mask != 0 && !statue.is_leaf(row))
      add(measure::FindingKind::kStructure,
          fmt::format("it is split, but its parent at {} is a leaf", statue.name(parent)));
    // Where a parent is a leaf, the node's other parents made it.
    if (!statue.is_leaf(parent) && statue.rows()[parent].error < own.error)
      add(measure::FindingKind::kErrorGrowth,
          fmt::format("its error {} is larger than {}, that of its parent at {}", own.error,
                      statue.rows()[parent].error, statue.name(parent)));
  }
  bool has_child = false;
  for (std::uint8_t place = 0; place < reader::diamonds::kMaxPlaces; ++place) {
    const reader::diamonds::TetrahedronRef ref{row, place};
    if (!statue.has_geometry(ref)) continue;
    if (!statue.exists(ref))
      add(measure::FindingKind::kStructure,
          fmt::format("place {} has geometry, but its parent has no node or is a leaf", place));
    if (statue.is_leaf(row)) continue;
    bool has_half = false;
    for (int end = 0; end < 2; ++end)
      if (const reader::diamonds::TetrahedronRef half = statue.child(ref, end);
          half.exists() && statue.has_geometry(half))
        has_half = true;
    if (!has_half)
      add(measure::FindingKind::kStructure,
          fmt::format("place {} has geometry and is split, but neither half has any", place));
    has_child = has_child || has_half;
  }
  if (!statue.is_leaf(row) && !has_child)
    add(measure::FindingKind::kStructure, "it is no leaf, but nothing lies below it");
  if (!statue.is_leaf(row) && (own.flags & container::kNodeIsAboveLimit) != 0)
    add(measure::FindingKind::kStructure, "it is above the leaf limit, but no leaf");
  if (own.tetra_mask == 0) add(measure::FindingKind::kStructure, "it has no tetrahedron");
  return findings;
}

std::optional<std::string> outside_bounds(const reader::diamonds::Statue& statue,
                                          reader::access::RowIndex row, const codec::coded::CodedPart& part,
                                          const hierarchy::Tetrahedron& tetrahedron) {
  const auto& bounds = statue.rows()[row].bounds;
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    const auto p = statue.world(codec::coded::scaled_position(part.positions[i], tetrahedron));
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (p[axis] < bounds[axis] || p[axis] > bounds[axis + 3])
        return fmt::format("vertex {} of place {} at {} {} {} lies outside the bounds {} to {} on axis {}", i,
                           part.place, p[0], p[1], p[2], bounds[axis], bounds[axis + 3], axis);
  }
  return std::nullopt;
}

// What the input is compared with, in scaled units.
void place_mesh(const reader::diamonds::Statue& statue, const measure::Scale& scale,
                const reader::diamonds::Node& node, NodeReport& report) {
  for (const auto& part : node.mesh.parts) {
    const auto base = static_cast<std::uint32_t>(report.points.size());
    for (const auto& weights : part.positions)
      report.points.push_back(scale.scaled(
          statue.world(codec::coded::scaled_position(weights, node.diamond.tetrahedra[part.place]))));
    for (const mesh::Triangle& t : part.triangles)
      report.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
}

void measure_node(const reader::diamonds::Statue& statue, const measure::VerifyOptions& options,
                  reader::access::RowIndex row, const measure::Input& input, NodeReport& report) {
  const measure::PartMeasure measured =
      measure_part(input, {report.points, report.triangles}, options.samples_per_node,
                   measure::seed_of(statue.rows()[row], options.seed));
  report.samples = measured.samples;
  report.greatest_distance = measured.greatest;
  report.greatest_of_vertices = measured.greatest;
  // Every vertex only where it can make a difference.
  if (statue.rows()[row].error > measure::kLooseFactor * report.greatest_distance) {
    std::uint32_t near = 0;
    for (const measure::WorldPoint& p : report.points) {
      const auto found = world_distance(input.scale(), input.index(), p, near);
      near = found.triangle;
      report.greatest_of_vertices = std::max(report.greatest_of_vertices, found.distance);
    }
    report.samples += report.points.size();
  }
  if (auto finding = measure::check_distance(statue, row, measured.farthest, measured.greatest))
    report.findings.push_back(std::move(*finding));
}

// Of one tetrahedron of a leaf.
measure::FinestSurface finest_part(const reader::diamonds::Statue& statue, reader::access::RowIndex row,
                                   const codec::coded::CodedPart& part,
                                   const hierarchy::Tetrahedron& tetrahedron) {
  measure::FinestSurface finest;
  finest.greatest_error = statue.rows()[row].error;
  finest.triangles = part.triangles.size();
  std::vector<codec::coded::ScaledPosition> positions;
  for (const auto& weights : part.positions)
    positions.push_back(codec::coded::scaled_position(weights, tetrahedron));
  for (const mesh::Triangle& t : part.triangles)
    for (const std::uint32_t v : t) finest.bounds.add(statue.world(positions[v]));
  add_area(finest, positions, part.triangles, std::ldexp(1.0, statue.metadata().position_bits));
  return finest;
}

// One tetrahedron by itself.
BoundaryChains check_part(const reader::diamonds::Statue& statue, reader::access::RowIndex row,
                          const codec::coded::CodedPart& part, const hierarchy::Tetrahedron& tetrahedron,
                          NodeReport& report) {
  if (const auto outside = outside_bounds(statue, row, part, tetrahedron))
    report.findings.push_back(
        {measure::FindingKind::kBounds, fmt::format("node at {}: {}", statue.name(row), *outside)});
  BoundaryChains chains = boundary_chains(part, tetrahedron);
  const reader::diamonds::WeldedTetrahedron welded = reader::diamonds::weld_positions(part, tetrahedron);
  measure::PartCensus census = measure::take_census(welded.positions, welded.zero_weights, welded.triangles);
  census.has_shared_places = welded.positions.size() < part.positions.size();
  report.inconsistent_edges += census.inconsistent_edges;
  if (statue.exists({row, part.place})) report.census.push_back(std::move(census));
  if (statue.is_leaf(row)) report.finest.add(finest_part(statue, row, part, tetrahedron));
  return chains;
}

NodeReport check_node(const reader::diamonds::Statue& statue, const measure::VerifyOptions& options,
                      const measure::Input* input, reader::access::RowIndex row) {
  NodeReport report;
  report.findings = check_structure(statue, row);
  const hierarchy::Diamond diamond = hierarchy::Diamond::at(statue.center(row));
  std::array<std::optional<BoundaryChains>, reader::diamonds::kMaxPlaces> chains;
  std::array<const BoundaryChains*, reader::diamonds::kMaxPlaces> present{};
  try {
    const reader::diamonds::Node node = statue.load(row);
    for (const auto& part : node.mesh.parts) {
      chains[part.place] = check_part(statue, row, part, diamond.tetrahedra[part.place], report);
      present[part.place] = &*chains[part.place];
    }
    if (input != nullptr) {
      place_mesh(statue, input->scale(), node, report);
      measure_node(statue, options, row, *input, report);
    }
  } catch (const core::Error& error) {
    if (error.status() != core::Status::kBadData) throw;
    report.is_damaged = true;
    report.findings.push_back({measure::FindingKind::kDamage, error.what()});
  }
  report.boundary = node_boundary(statue, row, diamond, present, report.is_damaged);
  return report;
}

class Verifier {
 public:
  Verifier(const reader::diamonds::Statue& statue, const measure::VerifyOptions& options)
      : statue_(statue),
        options_(options),
        log_(report_, options.examples_per_kind),
        is_damaged_(statue.rows().size(), false) {}

  measure::VerifyReport run() {
    const std::size_t rows = statue_.rows().size();
    report_.nodes = rows;
    if (options_.against != nullptr) {
      input_.emplace(statue_, *options_.against);
      input_->compare(log_);
      sampled_.resize(rows, 0.0);
    }
    if (rows == 0) log_.add({measure::FindingKind::kStructure, "the container has no nodes"});
    check_layout(statue_, log_);
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
      reader::access::parallel_for(batch.size(), [&](std::size_t i) {
        batch[i] = check_node(statue_, options_, input_ ? &*input_ : nullptr,
                              static_cast<reader::access::RowIndex>(begin + i));
      });
      for (std::size_t i = 0; i < batch.size(); ++i)
        merge(static_cast<reader::access::RowIndex>(begin + i), std::move(batch[i]));
      begin = end;
    }
    if (!report_.levels.empty()) finish_level();
    finish_boundaries();
    finish_finest();
    log_.check_census(statue_);
    log_.check_orientation(statue_);
    if (input_)
      count_loose(
          statue_, sampled_, is_damaged_, [&](auto row) { return parents(row); },
          [&](auto row) { return weight_unit(row); }, report_, log_);
    log_.sort();
    return std::move(report_);
  }

 private:
  void finish_level() {
    const measure::LevelCounts counts = census_.finish_level();
    measure::LevelReport& level = report_.levels.back();
    report_cut(counts, level);
    if (!input_) return;
    surface_.finish();
    const std::size_t spread = options_.samples_per_node * surface_.part_count() / kInputShare;
    measure_from_input(
        statue_, *input_, surface_,
        {level.level, level.level == statue_.deepest_level(), level.is_partial,
         std::min(kMostInputSamples, spread), options_.seed + level.level},
        [&](const measure::WorldPoint& p) { return held_error(statue_, level.level, p, is_damaged_); }, log_,
        sampled_);
    measure_loose(level.level);
    surface_.start_next();
  }

  // An error is of the node's own surface, and may be large where a neighbour's is nearer. So where errors of
  // this level still seem to be loose, more samples of the input are measured to what stands for them.
  void measure_loose(std::uint32_t level) {
    std::vector<std::size_t> parts;
    for (std::size_t i = 0; i < surface_.part_count(); ++i)
      if (const container::NodeRow& node = statue_.rows()[surface_.row(i)];
          node.level == level && node.error > measure::kLooseFactor * sampled_[surface_.row(i)])
        parts.push_back(i);
    if (parts.empty()) return;
    const std::vector<measure::WorldPoint> samples = loose_samples();
    reader::access::parallel_for(parts.size(), [&](std::size_t i) {
      const reader::access::RowIndex row = surface_.row(parts[i]);
      const container::NodeRow& node = statue_.rows()[row];
      const measure::SurfaceIndex index(surface_.surface(parts[i]));
      double greatest = sampled_[row];
      std::uint32_t near = 0;
      for (const measure::WorldPoint& p : samples) {
        const measure::WorldPoint q = input_->scale().world(p);
        if (!is_near(node, q) || held_error(statue_, level, q, is_damaged_).row != row) continue;
        const auto found = world_distance(input_->scale(), index, p, near);
        near = found.triangle;
        greatest = std::max(greatest, found.distance);
      }
      sampled_[row] = greatest;
    });
  }

  // The vertices of the input, of very large ones every k-th, and as many points spread over it.
  std::vector<measure::WorldPoint> loose_samples() const {
    const measure::Surface surface = input_->kept();
    const std::size_t stride = surface.points.size() / kMostLooseVertices + 1;
    std::vector<measure::WorldPoint> samples;
    for (std::size_t i = 0; i < surface.points.size(); i += stride) samples.push_back(surface.points[i]);
    const std::vector<measure::WorldPoint> spread = sample_surface(surface, samples.size(), options_.seed);
    samples.insert(samples.end(), spread.begin(), spread.end());
    return samples;
  }

  // Within the bounds, or no farther from them than the error on any axis.
  static bool is_near(const container::NodeRow& node, const measure::WorldPoint& p) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (p[axis] < node.bounds[axis] - node.error || p[axis] > node.bounds[axis + 3] + node.error)
        return false;
    return true;
  }

  void merge(reader::access::RowIndex row, NodeReport&& node) {
    measure::LevelReport& level = report_.levels.back();
    ++level.nodes;
    level.inconsistent_edges += node.inconsistent_edges;
    const bool is_leaf = statue_.is_leaf(row);
    if (node.is_damaged) {
      is_damaged_[row] = true;
      ++level.damaged_nodes;
      census_.add_damaged(is_leaf);
      finest_.is_whole = finest_.is_whole && !is_leaf;
    }
    for (measure::Finding& finding : node.findings) log_.add(std::move(finding));
    faces_.insert(faces_.end(), node.boundary.faces.begin(), node.boundary.faces.end());
    std::move(node.boundary.edges.begin(), node.boundary.edges.end(), std::back_inserter(edges_));
    for (measure::PartCensus& census : node.census) census_.add(std::move(census), is_leaf);
    finest_.add(node.finest);
    if (input_) surface_.add(row, node.points, node.triangles, is_leaf);
    if (node.samples == 0) return;
    report_.samples += node.samples;
    const double error = statue_.rows()[row].error;
    if (error > 0.0)
      report_.greatest_ratio = std::max(report_.greatest_ratio, node.greatest_distance / error);
    sampled_[row] = std::max(sampled_[row], node.greatest_of_vertices);
  }

  void finish_finest() {
    // Both sides of a face have the same edges in it, which is checked by itself.
    finest_.border_edges = census_.inside_leaves().border_edges;
    finest_.nonmanifold_edges = census_.inside_leaves().nonmanifold_edges;
    check_finest(statue_, finest_, log_);
  }

  void finish_boundaries() {
    BoundaryReport faces = check_faces(statue_, faces_, options_.examples_per_kind);
    report_.faces = faces.faces;
    report_.nonempty_faces = faces.nonempty_faces;
    log_.add_many(measure::FindingKind::kFace, faces.mismatches, std::move(faces.examples));
    BoundaryReport edges = check_edges(statue_, edges_, options_.examples_per_kind);
    report_.edges = edges.faces;
    log_.add_many(measure::FindingKind::kEdge, edges.mismatches, std::move(edges.examples));
  }

  // Those that are split.
  std::vector<reader::access::RowIndex> parents(reader::access::RowIndex row) const {
    std::vector<reader::access::RowIndex> parents = statue_.parents(row);
    std::erase_if(parents, [&](auto parent) { return statue_.is_leaf(parent); });
    return parents;
  }

  // How far one unit of weight moves a vertex of this node at most: on a flat input nothing else is left of
  // an error, and no distance shows it.
  double weight_unit(reader::access::RowIndex row) const {
    const hierarchy::Diamond diamond = hierarchy::Diamond::at(statue_.center(row));
    return std::sqrt(static_cast<double>(geometry::squared_distance(diamond.ends[0], diamond.ends[1]))) *
           statue_.lattice().step / static_cast<double>(std::int64_t{1} << statue_.metadata().position_bits);
  }

  const reader::diamonds::Statue& statue_;
  const measure::VerifyOptions& options_;
  measure::VerifyReport report_;
  measure::FindingLog log_;
  std::vector<bool> is_damaged_;  // per row, as far as they were decoded
  std::optional<measure::Input> input_;
  measure::LevelSurface surface_;
  std::vector<double> sampled_;  // per row, the greatest distance either way
  measure::FinestSurface finest_;
  std::vector<FaceEntry> faces_;
  std::vector<EdgeEntry> edges_;
  measure::LevelCensus census_;
};

}  // namespace

measure::VerifyReport verify(const reader::diamonds::Statue& statue, const measure::VerifyOptions& options) {
  return Verifier(statue, options).run();
}

}  // namespace colossus::verify::diamonds
