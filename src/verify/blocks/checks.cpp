#include "verify/blocks/checks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "core/error.hpp"

namespace colossus::verify::blocks {
namespace {

using geometry::Point;
using hierarchy::CubeId;

// A triangle by its positions, the least first in cyclic order: equal for equal orientations only.
using Corners = std::array<Point, 3>;

Corners cyclic(const Point& a, const Point& b, const Point& c) {
  Corners corners{a, b, c};
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return corners;
}

std::string text_of(const Point& p) { return fmt::format("({}, {}, {})", p.x, p.y, p.z); }
std::string text_of(const Corners& t) {
  return fmt::format("{} {} {}", text_of(t[0]), text_of(t[1]), text_of(t[2]));
}

class CubeChecker {
 public:
  CubeChecker(const reader::blocks::Statue& statue, reader::access::RowIndex row, const LevelFacts& facts)
      : statue_(statue), row_(row), facts_(facts) {}

  CubeReport run() {
    check_rows();
    auto mesh = load(row_);
    if (mesh) {
      report_.mesh = *std::move(mesh);
      check_own();
    }
    check_children(!report_.is_damaged);
    return std::move(report_);
  }

 private:
  void add(measure::FindingKind kind, reader::access::RowIndex row, const std::string& message) {
    report_.findings.push_back({kind, fmt::format("node at {}: {}", statue_.name(row), message)});
  }

  // Nothing when it is damaged, which is a finding of its own row only.
  std::optional<CheckedMesh> load(reader::access::RowIndex row) {
    try {
      return CheckedMesh(statue_.load(row));
    } catch (const core::Error& error) {
      if (error.status() != core::Status::kBadData) throw;
      if (row == row_) {
        report_.is_damaged = true;
        report_.findings.push_back({measure::FindingKind::kDamage, error.what()});
      }
      return std::nullopt;
    }
  }

  void check_rows() {
    const container::NodeRow& own = statue_.rows()[row_];
    if (own.level > 0) {
      if (const reader::access::RowIndex parent = statue_.parent(row_); parent == reader::access::kNoRow)
        add(measure::FindingKind::kStructure, row_, "its parent cube has no node");
      else if (statue_.rows()[parent].error < own.error)
        add(measure::FindingKind::kErrorGrowth, row_,
            fmt::format("its error {} is larger than {}, that of its parent", own.error,
                        statue_.rows()[parent].error));
    }
    const bool is_deepest = own.level == statue_.deepest_level();
    if (statue_.is_leaf(row_) != is_deepest)
      add(measure::FindingKind::kStructure, row_,
          is_deepest ? "it is of the deepest level, but no leaf"
                     : "it is a leaf, but not of the deepest level");
    const auto children = statue_.children(row_);
    if (!is_deepest && std::count(children.begin(), children.end(), reader::access::kNoRow) == 8)
      add(measure::FindingKind::kStructure, row_, "none of its children has a node");
  }

  void check_own() {
    const CheckedMesh& mesh = report_.mesh;
    const CubeId cube = statue_.cube(row_);
    const auto& bounds = statue_.rows()[row_].bounds;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const auto p = statue_.world(mesh.positions[i]);
      bool is_inside = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        is_inside = is_inside && p[axis] >= bounds[axis] && p[axis] <= bounds[axis + 3];
      if (is_inside) continue;
      add(measure::FindingKind::kBounds, row_,
          fmt::format("vertex {} at {} {} {} lies outside the row's bounds", i, p[0], p[1], p[2]));
      break;
    }
    check_edges(mesh, cube.level);
    take_own_census(mesh, cube);
    if (statue_.rows()[row_].level == statue_.deepest_level()) measure_finest(mesh);
    const double width = facts_.edge_length > 0.0 ? facts_.edge_length : edge_lengths(mesh.node).mean();
    report_.clefts = count_clefts(statue_, cube.level, mesh.node, width);
  }

  void check_edges(const CheckedMesh& mesh, int level) {
    std::uint64_t long_edges = 0;
    std::int64_t longest = 0;
    for (const mesh::Triangle& t : mesh.part().triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto length = hierarchy::max_distance(mesh.positions[t[k]], mesh.positions[t[(k + 1) % 3]]);
        longest = std::max(longest, length);
        // Lattice distances are exact doubles.
        if (static_cast<double>(length) > statue_.longest_edge(level)) ++long_edges;
      }
    if (long_edges > 0)
      add(measure::FindingKind::kCondition, row_,
          fmt::format("{} edges are longer than the {} that sigma0 allows, up to {} (lattice units)",
                      long_edges, statue_.longest_edge(level), longest));
  }

  // Whether other cubes of the level may have a vertex here.
  bool may_be_shared(const Point& p, const CubeId& cube, std::int64_t overhang) const {
    const Point low = cube.corner(statue_.root_bits());
    const std::int64_t side = cube.side(statue_.root_bits());
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] - low[axis] <= overhang || low[axis] + side - p[axis] <= overhang) return true;
    return false;
  }

  // Indices by position; equal ones in order.
  static std::vector<std::uint32_t> sorted_by_position(const CheckedMesh& mesh) {
    std::vector<std::uint32_t> order(mesh.positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::tie(mesh.positions[a], a) < std::tie(mesh.positions[b], b);
    });
    return order;
  }

  void take_own_census(const CheckedMesh& mesh, const CubeId& cube) {
    std::vector<codec::coded::ScaledPosition> positions;
    std::vector<std::uint8_t> is_shared;
    std::vector<std::uint32_t> welded(mesh.positions.size());
    const Point* before = nullptr;
    for (const std::uint32_t i : sorted_by_position(mesh)) {
      const Point& p = mesh.positions[i];
      if (before == nullptr || *before != p) {
        positions.push_back({p.x, p.y, p.z});
        is_shared.push_back(may_be_shared(p, cube, facts_.overhang) ? 1 : 0);
      }
      before = &p;
      welded[i] = static_cast<std::uint32_t>(positions.size() - 1);
    }
    std::vector<mesh::Triangle> triangles;
    for (const mesh::Triangle& t : mesh.part().triangles) {
      const mesh::Triangle w{welded[t[0]], welded[t[1]], welded[t[2]]};
      if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) triangles.push_back(w);
    }
    report_.census = measure::take_census(positions, is_shared, triangles);
    report_.census.has_shared_places = positions.size() < mesh.positions.size();
  }

  void measure_finest(const CheckedMesh& mesh) {
    measure::FinestSurface& finest = report_.finest;
    finest.greatest_error = statue_.rows()[row_].error;
    finest.triangles = mesh.part().triangles.size();
    std::vector<codec::coded::ScaledPosition> positions;
    for (const Point& p : mesh.positions) positions.push_back({p.x, p.y, p.z});
    for (const mesh::Triangle& t : mesh.part().triangles)
      for (const std::uint32_t v : t) finest.bounds.add(statue_.world(mesh.positions[v]));
    add_area(finest, positions, mesh.part().triangles, 1.0);
  }

  // The children's triangles under their parent maps, without degenerate ones, are this cube's.
  void check_children(bool has_mesh) {
    std::vector<Corners> mapped;
    bool is_whole = has_mesh;
    for (const reader::access::RowIndex child : statue_.children(row_)) {
      if (child == reader::access::kNoRow) continue;
      const auto mesh = load(child);
      if (!mesh) {
        is_whole = false;
        continue;
      }
      const EdgeLengths lengths = edge_lengths(mesh->node);
      report_.edge_lengths.sum += lengths.sum;
      report_.edge_lengths.count += lengths.count;
      if (!has_mesh) continue;
      if (!check_parents(child, *mesh)) {
        is_whole = false;
        continue;
      }
      report_.parents += mesh->part().parents.size();
      report_.mapped_triangles += mesh->part().triangles.size();
      collect_shared(child, *mesh);
      const auto& coarse = report_.mesh.positions;
      for (const mesh::Triangle& t : mesh->part().triangles) {
        const Point& a = coarse[mesh->part().parents[t[0]]];
        const Point& b = coarse[mesh->part().parents[t[1]]];
        const Point& c = coarse[mesh->part().parents[t[2]]];
        if (!mesh::is_degenerate(a, b, c)) mapped.push_back(cyclic(a, b, c));
      }
    }
    if (is_whole && statue_.rows()[row_].level < statue_.deepest_level()) compare_map(mapped);
  }

  // False when an index is out of range, so that the map says nothing.
  bool check_parents(reader::access::RowIndex child, const CheckedMesh& mesh) {
    const CheckedMesh& coarse = report_.mesh;
    const int level = statue_.cube(child).level;
    const double longest_allowed = statue_.longest_parent_distance(level);
    std::uint64_t far = 0;
    std::int64_t farthest = 0;
    for (std::size_t i = 0; i < mesh.part().parents.size(); ++i) {
      if (mesh.part().parents[i] >= coarse.positions.size()) {
        add(measure::FindingKind::kParent, child,
            fmt::format("vertex {} has parent {}, but the parent cube has {} vertices", i,
                        mesh.part().parents[i], coarse.positions.size()));
        return false;
      }
      const auto distance =
          hierarchy::max_distance(mesh.positions[i], coarse.positions[mesh.part().parents[i]]);
      farthest = std::max(farthest, distance);
      if (static_cast<double>(distance) > longest_allowed) ++far;
    }
    if (far > 0)
      add(measure::FindingKind::kCondition, child,
          fmt::format("{} vertices are farther from their parents than the {} that sigma0 allows, up to {} "
                      "(lattice units)",
                      far, longest_allowed, farthest));
    return true;
  }

  SharedVertex shared_vertex(reader::access::RowIndex child, const CheckedMesh& mesh, std::uint32_t i) const {
    SharedVertex vertex{mesh.positions[i], report_.mesh.positions[mesh.part().parents[i]], {}, {}, child};
    if (mesh.node.has_normals) vertex.normal = mesh.part().normals[i];
    if (mesh.node.has_colors) vertex.color = mesh.part().colors[i];
    return vertex;
  }

  // Vertices that other cubes may have, and those whose position the cube has twice.
  void collect_shared(reader::access::RowIndex child, const CheckedMesh& mesh) {
    const CubeId cube = statue_.cube(child);
    const std::vector<std::uint32_t> order = sorted_by_position(mesh);
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Point& p = mesh.positions[order[k]];
      const bool is_repeated = (k > 0 && mesh.positions[order[k - 1]] == p) ||
                               (k + 1 < order.size() && mesh.positions[order[k + 1]] == p);
      if (is_repeated || may_be_shared(p, cube, facts_.child_overhang))
        report_.shared.push_back(shared_vertex(child, mesh, order[k]));
    }
  }

  void compare_map(std::vector<Corners>& mapped) {
    std::vector<Corners> own;
    for (const mesh::Triangle& t : report_.mesh.part().triangles)
      own.push_back(
          cyclic(report_.mesh.positions[t[0]], report_.mesh.positions[t[1]], report_.mesh.positions[t[2]]));
    std::sort(own.begin(), own.end());
    std::sort(mapped.begin(), mapped.end());
    std::vector<Corners> missing;
    std::vector<Corners> extra;
    std::set_difference(mapped.begin(), mapped.end(), own.begin(), own.end(), std::back_inserter(missing));
    std::set_difference(own.begin(), own.end(), mapped.begin(), mapped.end(), std::back_inserter(extra));
    if (missing.empty() && extra.empty()) return;
    add(measure::FindingKind::kMap, row_,
        fmt::format(
            "the parent map makes {} triangles of its children's; it lacks {} of them and has {} others, "
            "such as {}",
            mapped.size(), missing.size(), extra.size(),
            text_of(missing.empty() ? extra.front() : missing.front())));
  }

  const reader::blocks::Statue& statue_;
  const reader::access::RowIndex row_;
  const LevelFacts& facts_;
  CubeReport report_;
};

}  // namespace

std::int64_t greatest_overhang(const reader::blocks::Statue& statue, std::uint32_t level) {
  const container::LatticeInfo& lattice = statue.metadata().lattice;
  double greatest = 0.0;
  const reader::access::RowRange range = statue.rows_of_level(level);
  for (reader::access::RowIndex row = range.first; row < range.last; ++row) {
    const CubeId cube = statue.cube(row);
    const Point low = cube.corner(statue.root_bits());
    const auto side = static_cast<double>(cube.side(statue.root_bits()));
    const auto& bounds = statue.rows()[row].bounds;
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      greatest = std::max({greatest, low[axis] - (bounds[k] - lattice.origin[k]) / lattice.step,
                           (bounds[k + 3] - lattice.origin[k]) / lattice.step - low[axis] - side});
    }
  }
  // One for the rounding of the bounds; what exceeds the root cube need not be told apart.
  return static_cast<std::int64_t>(std::ceil(std::min(greatest, std::ldexp(1.0, statue.root_bits())))) + 1;
}

CubeReport check_cube(const reader::blocks::Statue& statue, reader::access::RowIndex row,
                      const LevelFacts& facts) {
  return CubeChecker(statue, row, facts).run();
}

std::vector<measure::Finding> check_shared(const reader::blocks::Statue& statue,
                                           std::vector<SharedVertex>& vertices) {
  const auto key = [](const SharedVertex& v) {
    return std::tie(v.position, v.row, v.parent, v.normal, v.color);
  };
  std::sort(vertices.begin(), vertices.end(),
            [&](const SharedVertex& a, const SharedVertex& b) { return key(a) < key(b); });
  std::vector<measure::Finding> findings;
  for (std::size_t i = 1; i < vertices.size(); ++i) {
    const SharedVertex& a = vertices[i - 1];
    const SharedVertex& b = vertices[i];
    if (a.position != b.position) continue;
    const char* what = a.parent != b.parent   ? "the parent"
                       : a.normal != b.normal ? "the normal"
                       : a.color != b.color   ? "the colour"
                                              : nullptr;
    if (what != nullptr)
      findings.push_back({measure::FindingKind::kShared,
                          fmt::format("nodes at {} and at {}: they disagree about {} of the vertex at {}",
                                      statue.name(a.row), statue.name(b.row), what, text_of(a.position))});
  }
  return findings;
}

}  // namespace colossus::verify::blocks
