#include "simplify/collapse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "core/error.hpp"
#include "geometry/attribute_quadric.hpp"
#include "geometry/quadric.hpp"
#include "mesh/adjacency.hpp"
#include "simplify/candidates.hpp"
#include "simplify/components.hpp"
#include "simplify/deviation.hpp"
#include "simplify/merged_box.hpp"
#include "simplify/next_borders.hpp"
#include "simplify/survivors.hpp"
#include "simplify/vertex_class.hpp"

namespace colossus::simplify {
namespace {

using geometry::Point;
using geometry::Vec3;
using mesh::Triangle;

constexpr std::uint32_t kNone = ~std::uint32_t{0};
// Planes across the input's border, against the triangles' own: a border is more visible than its area says.
constexpr double kBorderWeight = 4.0;
// A triangle may turn by at most about 78 degrees in one collapse.
constexpr double kLeastTurnCosine = 0.2;
// Height over longest side below which a triangle's own normal says nothing: clip slivers, rounded to the
// lattice.
constexpr double kFlatness = 1e-3;
// A pass accepts costs up to this factor over that of the last collapse that it would need.
constexpr float kPassCostFactor = 1.5F;
// Of the costs of half-edge collapses: onto a locked vertex, whose triangles then become fewer, and between
// two vertices of a border that will be locked in the next simplification, when it cannot be thinned out.
// Measured, see src/README.md.
constexpr double kOntoLockedFactor = 0.4;
constexpr double kAlongNextBorderFactor = 0.2;
constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();

// Measures the error of a collapse with geometry::Quadric, in space, or with geometry::AttributeQuadric, in
// space and colour, which has half-edge collapses only.
template <typename Quadric>
class Collapser {
 public:
  Collapser(Region& region, std::size_t target) : region_(region), target_(target) {}

  Outcome run() {
    Outcome outcome;
    outcome.initial_triangles = triangles().size();
    outcome.initial_vertices = region_.mesh.vertices.size();
    prepare();
    outcome.locked_vertices =
        static_cast<std::uint64_t>(std::count(classes_.begin(), classes_.end(), VertexClass::kLocked));
    for (std::size_t breadth = 1; live_count_ > target_;) {
      const std::size_t before = live_count_;
      const bool tried_all = pass(breadth);
      ++outcome.passes;
      drop_dead_triangles(region_);
      // Below a thousandth of what is still wanted: the cheapest collapses left are illegal, or all are, and
      // further passes only cost time.
      if ((before - live_count_) * 1000 > before - target_) continue;
      if (tried_all) break;
      breadth *= 8;
    }
    finish(outcome);
    outcome.final_triangles = triangles().size();
    return outcome;
  }

 private:
  static constexpr bool kHasColors = std::is_same_v<Quadric, geometry::AttributeQuadric>;

  std::vector<Triangle>& triangles() { return region_.mesh.triangles; }
  FaceMask faces(std::uint32_t v) const { return region_.faces[v]; }

  void prepare() {
    before_ = region_.mesh;
    const std::size_t count = region_.mesh.vertices.size();
    adjacency_.build(triangles(), count);
    classes_ = classify_vertices(region_, adjacency_);
    // Local coordinates keep the quadrics' constants small.
    const Vec3 origin = count > 0 ? geometry::to_vec3(region_.mesh.vertices[0].position) : Vec3{};
    origin_ = origin;
    positions_.resize(count);
    representative_.resize(count);
    for (std::uint32_t v = 0; v < count; ++v) {
      positions_[v] = geometry::to_vec3(region_.mesh.vertices[v].position) - origin;
      representative_[v] = v;
    }
    if (region_.reach != kNoLimit)
      for (const mesh::Vertex& vertex : region_.mesh.vertices)
        merged_.push_back({vertex.position, vertex.position});
    if constexpr (kHasColors) color_unit_ = region_.color_weight * mean_side() / 255.0;
    stamps_.assign(count, 0);
    live_count_ = triangles().size();
  }

  double mean_side() {
    double sum = 0.0;
    for (const Triangle& t : triangles())
      for (std::size_t k = 0; k < 3; ++k)
        sum += geometry::length(positions_[t[(k + 1) % 3]] - positions_[t[k]]);
    return triangles().empty() ? 0.0 : sum / (3.0 * static_cast<double>(triangles().size()));
  }

  // Where v lies in the space in which errors are measured.
  auto place_of(std::uint32_t v) const {
    if constexpr (kHasColors) {
      const mesh::Color& color = region_.mesh.vertices[v].color;
      return geometry::AttributePoint(
          positions_[v], color_unit_ * Vec3{double(color[0]), double(color[1]), double(color[2])});
    } else {
      return positions_[v];
    }
  }

  // Collapses half of what is still wanted, if all of the cheapest candidates were legal; looks at `breadth`
  // times as many. Returns whether these were all.
  bool pass(std::size_t breadth) {
    const std::size_t count = positions_.size();
    adjacency_.build(triangles(), count);
    is_touched_.assign(count, false);
    compute_quadrics();
    next_borders_.find(region_);
    collect_candidates();
    if (candidates_.empty()) return true;
    const std::size_t rank = breadth * (live_count_ - target_) / 2;
    const bool is_all = rank >= candidates_.size();
    if (!is_all) drop_costly(candidates_, rank, kPassCostFactor);
    sort_by_cost(candidates_, sorted_);
    cost_limit_ = is_all ? std::numeric_limits<double>::infinity() : double{candidates_.back().cost};
    for (std::size_t i = 0; i < candidates_.size() && live_count_ > target_; ++i) {
      fetch_ahead(i);
      const Candidate candidate = candidates_[i];
      if (is_touched_[candidate.from] || is_touched_[candidate.to]) continue;
      collapse(candidate.from, candidate.to);
    }
    return is_all;
  }

  // Candidates by cost are all over the mesh: what the next ones need is asked for in time. Inlined, since
  // g++ takes a function of prefetches for one without effect.
  [[gnu::always_inline]] void fetch_ahead(std::size_t i) const {
    constexpr std::size_t kListsAhead = 12;
    constexpr std::size_t kTrianglesAhead = 6;
    if (i + kListsAhead >= candidates_.size()) return;
    const Candidate& far = candidates_[i + kListsAhead];
    __builtin_prefetch(adjacency_.around(far.from).data());
    __builtin_prefetch(adjacency_.around(far.to).data());
    const Candidate& near = candidates_[i + kTrianglesAhead];
    for (const auto t : adjacency_.around(near.from)) __builtin_prefetch(&region_.mesh.triangles[t]);
    for (const auto t : adjacency_.around(near.to)) __builtin_prefetch(&region_.mesh.triangles[t]);
  }

  void compute_quadrics() {
    quadrics_.assign(positions_.size(), Quadric{});
    for (std::uint32_t i = 0; i < triangles().size(); ++i) {
      const Triangle& t = triangles()[i];
      const Vec3 n = normal_of(t);
      const double doubled_area = geometry::length(n);
      if (!(doubled_area > 0.0)) continue;
      Quadric q;
      if constexpr (kHasColors)
        q.add_triangle(place_of(t[0]), place_of(t[1]), place_of(t[2]), doubled_area);
      else
        q.add_plane((1.0 / doubled_area) * n, positions_[t[0]], doubled_area);
      for (const auto v : t) quadrics_[v].add(q);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k];
        const std::uint32_t b = t[(k + 1) % 3];
        if (classes_[a] != VertexClass::kBorder && classes_[b] != VertexClass::kBorder) continue;
        if (!is_border_edge(a, b)) continue;
        const Vec3 along = positions_[b] - positions_[a];
        const Vec3 across = geometry::cross(along, n);
        const double across_length = geometry::length(across);
        if (!(across_length > 0.0)) continue;
        Quadric wall;
        wall.add_plane((1.0 / across_length) * across, positions_[a],
                       kBorderWeight * geometry::squared_length(along));
        quadrics_[a].add(wall);
        quadrics_[b].add(wall);
      }
    }
  }

  void collect_candidates() {
    candidates_.clear();
    for (const Triangle& t : triangles())
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k];
        const std::uint32_t b = t[(k + 1) % 3];
        // Each edge once: from the triangle that sees it in index order, or the only one that it has.
        if (a > b && !(may_be_border(a) && may_be_border(b) && is_border_edge(a, b))) continue;
        add_candidate(a, b);
      }
  }

  bool may_be_border(std::uint32_t v) const {
    return classes_[v] == VertexClass::kBorder || classes_[v] == VertexClass::kLocked;
  }

  void add_candidate(std::uint32_t a, std::uint32_t b) {
    if constexpr (!kHasColors)
      if (is_placed(a, b)) {
        const Vec3 best = optimum(a, b);
        candidates_.push_back({static_cast<float>(quadrics_[a].at(best) + quadrics_[b].at(best)), a, b});
        return;
      }
    const bool forth = may_move(a, b);
    const bool back = may_move(b, a);
    if (!forth && !back) return;
    const double cost_forth = forth ? cost_of(a, b) : 0.0;
    const double cost_back = back ? cost_of(b, a) : 0.0;
    if (forth && (!back || cost_forth <= cost_back))
      candidates_.push_back({static_cast<float>(cost_forth), a, b});
    else
      candidates_.push_back({static_cast<float>(cost_back), b, a});
  }

  // Of moving a onto b.
  double cost_of(std::uint32_t a, std::uint32_t b) const {
    const auto place = place_of(b);
    double cost = quadrics_[a].at(place) + quadrics_[b].at(place);
    if (region_.may_place) return cost;
    if ((faces(b) & region_.outer_faces) != 0) cost *= kOntoLockedFactor;
    if (next_borders_.has(a) && next_borders_.has(b)) cost *= kAlongNextBorderFactor;
    return cost;
  }

  // Whether a collapse of a and b looks for a new place.
  bool is_placed(std::uint32_t a, std::uint32_t b) const {
    return region_.may_place && classes_[a] == VertexClass::kFree && classes_[b] == VertexClass::kFree;
  }

  // The classes and the reach alone, which no other collapse of the pass changes: whether a may be moved onto
  // its neighbour b.
  bool may_move(std::uint32_t a, std::uint32_t b) const {
    if (classes_[a] == VertexClass::kLocked || (faces(a) & ~faces(b)) != 0) return false;
    if (!merged_.empty() && !merged_[a].is_within(region_.reach, region_.mesh.vertices[b].position))
      return false;
    return classes_[a] != VertexClass::kBorder || (may_be_border(b) && is_border_edge(a, b));
  }

  Vec3 optimum(std::uint32_t a, std::uint32_t b) const {
    Quadric q = quadrics_[a];
    q.add(quadrics_[b]);
    const Vec3 middle = 0.5 * (positions_[a] + positions_[b]);
    const Vec3 best = q.minimum(middle);
    // Far from the edge the planes say little about the surface.
    if (geometry::squared_length(best - middle) > geometry::squared_length(positions_[b] - positions_[a]))
      return middle;
    return best;
  }

  void collapse(std::uint32_t a, std::uint32_t b) {
    if constexpr (!kHasColors)
      if (is_placed(a, b)) {
        if (is_link_legal(a, b)) place(a, b);
        return;
      }
    if (!is_link_legal(a, b)) return;
    if (is_end_legal(a, b))
      apply(a, b);
    else if (!region_.may_place && may_move(b, a) && is_cheap(b, a) && is_end_legal(b, a))
      apply(b, a);
  }

  // Whether the pass may make the dearer collapse of an edge. With colours the two ends can differ by orders
  // of magnitude: on a painted plane all is free but to pull a vertex out of an edge between two colours.
  bool is_cheap(std::uint32_t a, std::uint32_t b) const {
    if constexpr (kHasColors) return cost_of(a, b) <= cost_limit_;
    return true;
  }

  // Moves both to their optimum, if that keeps what is_link_legal() leaves open.
  void place(std::uint32_t a, std::uint32_t b) {
    const Vec3 best = optimum(a, b);
    const Vec3 world = best + origin_;
    const Point rounded{static_cast<std::int32_t>(std::floor(world.x + 0.5)),
                        static_cast<std::int32_t>(std::floor(world.y + 0.5)),
                        static_cast<std::int32_t>(std::floor(world.z + 0.5))};
    if (is_strictly_inside_cell(rounded, shared_cell_)) {
      const Vec3 target = geometry::to_vec3(rounded) - origin_;
      if (keeps_orientation(a, b, target) && keeps_orientation(b, a, target)) {
        place_between(a, b, rounded, target);
        apply(a, b);
        return;
      }
    }
    // No room for the optimum: the cheaper end will do.
    if (quadrics_[a].at(positions_[b]) > quadrics_[b].at(positions_[a])) std::swap(a, b);
    if (keeps_orientation(a, b, positions_[b])) apply(a, b);
  }

  // What is_link_legal() leaves open, that the collapse of a into b keeps faces and orientation.
  bool is_end_legal(std::uint32_t a, std::uint32_t b) {
    if (!respects_faces(a, b) || !keeps_orientation(a, b, positions_[b])) return false;
    // A border collapse takes a triangle away: an edge of the face polyline may not become the border by it.
    return border_apex_ == kNone || (faces(b) & faces(border_apex_)) == 0;
  }

  // Link condition on live connectivity; also finds the cell of a triangle at the edge, and the apex of a
  // border edge.
  bool is_link_legal(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t in_b = ++stamp_;
    for_each_live(b, [&](const Triangle& t) {
      for (const auto v : t) stamps_[v] = in_b;
    });
    std::array<std::uint32_t, 2> apexes{kNone, kNone};
    std::size_t shared = 0;
    std::size_t common = 0;
    const std::uint32_t seen = ++stamp_;
    for (const std::uint32_t i : adjacency_.around(a)) {
      const Triangle& t = triangles()[i];
      if (is_dead(t)) continue;
      const bool has_b = t[0] == b || t[1] == b || t[2] == b;
      if (has_b) {
        COLOSSUS_CHECK(shared < 2, "an edge of more than two triangles between vertices that may move");
        shared_cell_ = region_.cells[i];
        for (const auto v : t)
          if (v != a && v != b) apexes[shared] = v;
        ++shared;
      }
      for (const auto v : t) {
        if (v == a || v == b || stamps_[v] == seen) continue;
        if (stamps_[v] == in_b) ++common;
        stamps_[v] = seen;
      }
    }
    if (common != shared) return false;
    border_apex_ = shared == 1 ? apexes[0] : kNone;
    for (std::size_t k = 0; k < shared; ++k)
      if (count_at_edge(a, apexes[k]) + count_at_edge(b, apexes[k]) <= 2) return false;
    // A triangle of a and one of b over the same two apexes would fall together.
    if (shared == 2 && has_triangle(a, apexes[0], apexes[1]) && has_triangle(b, apexes[0], apexes[1]))
      return false;
    return true;
  }

  bool respects_faces(std::uint32_t a, std::uint32_t b) {
    if (faces(b) == 0) return true;
    const std::uint32_t in_b = ++stamp_;
    for_each_live(b, [&](const Triangle& t) {
      for (const auto v : t) stamps_[v] = in_b;
    });
    for (const std::uint32_t i : adjacency_.around(a)) {
      const Triangle& t = triangles()[i];
      if (is_dead(t) || t[0] == b || t[1] == b || t[2] == b) continue;
      FaceMask common = faces(b);
      for (const auto v : t) {
        if (v == a) continue;
        if (stamps_[v] != in_b && (faces(b) & faces(v) & ~faces(a)) != 0) return false;
        common &= faces(v);
      }
      if (common != 0) return false;
    }
    return true;
  }

  bool keeps_orientation(std::uint32_t moving, std::uint32_t other, const Vec3& target) const {
    Vec3 fan{};
    bool has_fan = false;
    for (const std::uint32_t i : adjacency_.around(moving)) {
      const Triangle& t = region_.mesh.triangles[i];
      if (is_dead(t) || t[0] == other || t[1] == other || t[2] == other) continue;
      const std::size_t k = t[0] == moving ? 0 : t[1] == moving ? 1 : 2;
      const Vec3& p = positions_[t[(k + 1) % 3]];
      const Vec3& q = positions_[t[(k + 2) % 3]];
      const Vec3 side = q - p;
      const Vec3 old_normal = geometry::cross(side, positions_[moving] - p);
      const Vec3 new_normal = geometry::cross(side, target - p);
      const double old_area = geometry::squared_length(old_normal);
      const double new_area = geometry::squared_length(new_normal);
      const double cosine_times_areas = geometry::dot(old_normal, new_normal);
      if (!is_flat(old_area, side, positions_[moving] - p, positions_[moving] - q)) {
        if (!(cosine_times_areas > 0.0) || cosine_times_areas * cosine_times_areas <
                                               kLeastTurnCosine * kLeastTurnCosine * old_area * new_area)
          return false;
        continue;
      }
      // A sliver's own normal is noise: what counts is the side that its neighbours face.
      if (!has_fan) fan = fan_normal(moving);
      has_fan = true;
      if (geometry::dot(new_normal, fan) < 0.0) return false;
    }
    return true;
  }

  static bool is_flat(double area, const Vec3& u, const Vec3& v, const Vec3& w) {
    const double longest =
        std::max({geometry::squared_length(u), geometry::squared_length(v), geometry::squared_length(w)});
    return area <= kFlatness * kFlatness * longest * longest;
  }

  Vec3 fan_normal(std::uint32_t v) const {
    Vec3 sum{};
    for (const std::uint32_t i : adjacency_.around(v))
      if (!is_dead(region_.mesh.triangles[i])) sum = sum + normal_of(region_.mesh.triangles[i]);
    return sum;
  }

  void place_between(std::uint32_t a, std::uint32_t b, const Point& rounded, const Vec3& target) {
    const Vec3 along = positions_[b] - positions_[a];
    const double squared = geometry::squared_length(along);
    const double t =
        squared > 0.0 ? std::clamp(geometry::dot(target - positions_[a], along) / squared, 0.0, 1.0) : 0.5;
    constexpr std::int64_t kParts = 1 << 16;
    auto& vertices = region_.mesh.vertices;
    vertices[b] = mesh::interpolate(vertices[a], vertices[b], static_cast<std::int64_t>(t * kParts), kParts);
    vertices[b].position = rounded;
    positions_[b] = target;
  }

  void apply(std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t i : adjacency_.around(a)) {
      Triangle& t = triangles()[i];
      if (is_dead(t)) continue;
      if (t[0] == b || t[1] == b || t[2] == b) {
        t = kDeadTriangle;
        --live_count_;
      } else {
        for (auto& v : t) v = v == a ? b : v;
      }
    }
    is_touched_[a] = is_touched_[b] = true;
    representative_[a] = b;
    if (!merged_.empty()) merged_[b].add(merged_[a]);
  }

  // Drops dead vertices, and measures what has become of the surface.
  void finish(Outcome& outcome) {
    outcome.representative = drop_dead_vertices(region_, std::move(representative_));
    const bool has_border =
        std::find(classes_.begin(), classes_.end(), VertexClass::kBorder) != classes_.end();
    const Deviation deviation = measure_deviation(before_, region_.mesh, region_.cells,
                                                  outcome.representative, has_border, region_.samples);
    outcome.deviation = deviation.estimate();
    // With the margin of all that is measured at some places only: what rests on a component now may have to
    // rest on another one later.
    const double limit = std::max(outcome.deviation, region_.known_error) / kDeviationMargin;
    const double dropped = drop_components(region_, target_, limit, before_.vertices, outcome.representative);
    outcome.deviation = std::max(outcome.deviation, dropped);
  }

  template <typename Visit>
  void for_each_live(std::uint32_t v, const Visit& visit) const {
    for (const std::uint32_t i : adjacency_.around(v))
      if (!is_dead(region_.mesh.triangles[i])) visit(region_.mesh.triangles[i]);
  }
  static bool has_vertex(const Triangle& t, std::uint32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

  // Live triangles around a that also hold b; a must be untouched in this pass.
  std::size_t count_at_edge(std::uint32_t a, std::uint32_t b) const {
    std::size_t count = 0;
    for (const std::uint32_t i : adjacency_.around(a)) {
      const Triangle& t = region_.mesh.triangles[i];
      count += !is_dead(t) && has_vertex(t, b) ? 1 : 0;
    }
    return count;
  }
  bool is_border_edge(std::uint32_t a, std::uint32_t b) const { return count_at_edge(a, b) == 1; }
  bool has_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    for (const std::uint32_t i : adjacency_.around(a)) {
      const Triangle& t = region_.mesh.triangles[i];
      if (!is_dead(t) && has_vertex(t, b) && has_vertex(t, c)) return true;
    }
    return false;
  }
  Vec3 normal_of(const Triangle& t) const {
    return geometry::cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
  }
  bool is_strictly_inside_cell(const Point& p, std::uint16_t cell) const {
    for (const geometry::Plane& plane : region_.cell_planes[cell])
      if (plane.side(p) <= 0) return false;
    return true;
  }

  Region& region_;
  std::size_t target_;
  std::size_t live_count_ = 0;
  mesh::Mesh before_;
  Vec3 origin_;
  mesh::Adjacency adjacency_;
  std::vector<VertexClass> classes_;
  std::vector<Vec3> positions_;
  double color_unit_ = 0.0;  // lattice units per step of a colour
  std::vector<Quadric> quadrics_;
  NextBorders next_borders_;
  std::vector<Candidate> candidates_;
  double cost_limit_ = 0.0;  // of the pass
  std::vector<Candidate> sorted_;
  std::vector<std::uint32_t> representative_;
  std::vector<MergedBox> merged_;  // per vertex; empty without a reach
  std::vector<std::uint32_t> stamps_;
  std::vector<bool> is_touched_;
  std::uint32_t stamp_ = 0;
  std::uint16_t shared_cell_ = 0;
  std::uint32_t border_apex_ = kNone;
};

}  // namespace

Outcome simplify(Region& region, std::size_t target_triangles) {
  COLOSSUS_CHECK(region.faces.size() == region.mesh.vertices.size());
  COLOSSUS_CHECK(region.cells.size() == region.mesh.triangles.size());
  COLOSSUS_CHECK(!region.may_place || region.reach == kNoLimit, "a reach is for half-edge collapses only");
  COLOSSUS_CHECK(region.color_weight == 0.0 || (region.color_weight > 0.0 && !region.may_place),
                 "colours count in half-edge collapses only");
  if (region.color_weight > 0.0) return Collapser<geometry::AttributeQuadric>(region, target_triangles).run();
  return Collapser<geometry::Quadric>(region, target_triangles).run();
}

}  // namespace colossus::simplify
