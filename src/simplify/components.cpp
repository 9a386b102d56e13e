#include "simplify/components.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "geometry/vector.hpp"
#include "simplify/deviation.hpp"
#include "simplify/merged_box.hpp"
#include "simplify/survivors.hpp"

namespace colossus::simplify {
namespace {

using geometry::Point;
using geometry::Vec3;
using mesh::Triangle;

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr std::size_t kChunkTriangles = 32;
// Of chunks, in one region; what is left then stays.
constexpr std::uint64_t kMostLooks = std::uint64_t{1} << 30;

struct Box {
  Point low, high;
  bool is_empty = true;
  void add(const Point& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = is_empty ? p[axis] : std::min(low[axis], p[axis]);
      high[axis] = is_empty ? p[axis] : std::max(high[axis], p[axis]);
    }
    is_empty = false;
  }
  // Whether some point of it may be within `limit` of all points of the other.
  bool is_near(const Box& other, double limit) const {
    for (int axis = 0; axis < 3; ++axis)
      if (static_cast<double>(std::int64_t{low[axis]} - other.low[axis]) > limit ||
          static_cast<double>(std::int64_t{other.high[axis]} - high[axis]) > limit)
        return false;
    return true;
  }
};

struct Component {
  std::uint32_t triangles = 0;
  Box box;
  Point least;  // of its corners: tells components apart, whatever the order of the triangles
  bool is_free = true;
  double carried = 0.0;                 // greatest distance of a sample
  std::vector<std::uint32_t> vertices;  // ascending
  bool is_dropped = false;
  bool is_support = false;  // a dropped one relies on it
};

class ComponentDropper {
 public:
  ComponentDropper(Region& region, const std::vector<mesh::Vertex>& before,
                   std::vector<std::uint32_t>& representative)
      : region_(region), before_(before), representative_(representative) {}

  double run(std::size_t target, double limit) {
    find_components();
    if (components_.size() < 2) return 0.0;
    describe();
    std::vector<std::uint32_t> order;
    for (std::uint32_t c = 0; c < components_.size(); ++c)
      if (components_[c].is_free && components_[c].carried <= limit) order.push_back(c);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const Component &x = components_[a], &y = components_[b];
      return std::tie(x.triangles, x.least, a) < std::tie(y.triangles, y.least, b);
    });
    std::size_t live = triangles().size();
    for (const std::uint32_t c : order) {
      if (live <= target || looked_at_ > kMostLooks) break;
      if (!drop(c, limit)) continue;
      live -= components_[c].triangles;
    }
    if (live < triangles().size()) finish();
    return farthest_;
  }

 private:
  std::vector<Triangle>& triangles() { return region_.mesh.triangles; }
  const Point& at(std::uint32_t v) const { return region_.mesh.vertices[v].position; }

  std::uint32_t root_of(std::uint32_t v) {
    while (roots_[v] != v) v = roots_[v] = roots_[roots_[v]];
    return v;
  }

  void find_components() {
    roots_.resize(region_.mesh.vertices.size());
    for (std::uint32_t v = 0; v < roots_.size(); ++v) roots_[v] = v;
    for (const Triangle& t : triangles())
      for (const std::size_t k : {std::size_t{1}, std::size_t{2}}) {
        const std::uint32_t a = root_of(t[0]), b = root_of(t[k]);
        if (a != b) roots_[std::max(a, b)] = std::min(a, b);
      }
    std::vector<std::uint32_t> number(roots_.size(), kNone);
    for (const Triangle& t : triangles()) {
      std::uint32_t& own = number[root_of(t[0])];
      if (own == kNone) {
        own = static_cast<std::uint32_t>(components_.size());
        components_.emplace_back();
      }
      component_of_.push_back(own);
      ++components_[own].triangles;
    }
    component_of_vertex_.resize(roots_.size());
    for (std::uint32_t v = 0; v < roots_.size(); ++v) component_of_vertex_[v] = number[root_of(v)];
  }

  void describe() {
    for (std::uint32_t v = 0; v < component_of_vertex_.size(); ++v) {
      if (component_of_vertex_[v] == kNone) continue;
      Component& component = components_[component_of_vertex_[v]];
      component.least = component.vertices.empty() ? at(v) : std::min(component.least, at(v));
      component.vertices.push_back(v);
      component.box.add(at(v));
      component.is_free = component.is_free && region_.faces[v] == 0;
    }
    for (const SurfaceSample& sample : region_.samples)
      if (const std::uint32_t c = component_of_vertex_[sample.anchor]; c != kNone)
        components_[c].carried = std::max(components_[c].carried, double{sample.distance});
    chunks_.resize((triangles().size() + kChunkTriangles - 1) / kChunkTriangles);
    for (std::size_t i = 0; i < triangles().size(); ++i)
      for (const auto v : triangles()[i]) chunks_[i / kChunkTriangles].add(at(v));
    if (region_.reach != std::numeric_limits<std::int64_t>::max()) {
      std::vector<bool> is_known(region_.mesh.vertices.size(), false);
      merged_.resize(is_known.size());
      for (std::uint32_t v = 0; v < before_.size(); ++v) {
        const MergedBox own{before_[v].position, before_[v].position};
        MergedBox& box = merged_[representative_[v]];
        if (is_known[representative_[v]])
          box.add(own);
        else
          box = own;
        is_known[representative_[v]] = true;
      }
    }
    becomes_.resize(region_.mesh.vertices.size());
    for (std::uint32_t v = 0; v < becomes_.size(); ++v) becomes_[v] = v;
  }

  bool drop(std::uint32_t c, double limit) {
    Component& component = components_[c];
    if (component.is_support) return false;
    const double distance = limit - component.carried;
    // The least triangle in space that will do, not the first in the list.
    std::optional<std::array<Point, 3>> best;
    std::uint32_t support = kNone, heir = kNone, nearest = kNone;
    looked_at_ += chunks_.size();
    for (std::size_t chunk = 0; chunk < chunks_.size(); ++chunk) {
      if (!chunks_[chunk].is_near(component.box, distance)) continue;
      const std::size_t end = std::min((chunk + 1) * kChunkTriangles, triangles().size());
      for (std::size_t i = chunk * kChunkTriangles; i < end; ++i) {
        const std::uint32_t other = component_of_[i];
        if (other == c || components_[other].is_dropped) continue;
        const std::array<Point, 3> key = sorted_corners(triangles()[i]);
        if ((best && !(key < *best)) || !is_within(component, triangles()[i], distance)) continue;
        const std::uint32_t to = heir_of(component, triangles()[i]);
        if (to == kNone) continue;
        best = key;
        support = other;
        heir = to;
        nearest = static_cast<std::uint32_t>(i);
      }
    }
    if (support == kNone) return false;
    component.is_dropped = true;
    components_[support].is_support = true;
    for (const auto v : component.vertices) becomes_[v] = heir;
    farthest_ = std::max(farthest_, pin_farthest(component, triangles()[nearest]) + component.carried);
    return true;
  }

  // A sample at the corner that is farthest from what stands for the component: the input's samples may have
  // been thinned out there. Returns how far that is.
  double pin_farthest(const Component& component, const Triangle& support) {
    std::uint32_t farthest = component.vertices.front();
    double greatest = -1.0;
    for (const auto v : component.vertices) {
      const double squared = squared_distance(v, support);
      if (squared > greatest || (squared == greatest && at(v) < at(farthest))) {
        greatest = squared;
        farthest = v;
      }
    }
    region_.samples.push_back({at(farthest), farthest, 0.0F, 0, 1});
    return std::sqrt(greatest);
  }

  double squared_distance(std::uint32_t v, const Triangle& t) const {
    return geometry::distance_to_triangle(geometry::to_vec3(at(v)), geometry::to_vec3(at(t[0])),
                                          geometry::to_vec3(at(t[1])), geometry::to_vec3(at(t[2])),
                                          std::numeric_limits<double>::infinity())
        .squared;
  }

  std::array<Point, 3> sorted_corners(const Triangle& t) const {
    std::array<Point, 3> corners{at(t[0]), at(t[1]), at(t[2])};
    std::sort(corners.begin(), corners.end());
    return corners;
  }

  // The distance from a triangle is convex: no point of the component is farther than its farthest corner.
  bool is_within(const Component& component, const Triangle& t, double distance) const {
    const Vec3 a = geometry::to_vec3(at(t[0])), b = geometry::to_vec3(at(t[1])),
               c = geometry::to_vec3(at(t[2]));
    return std::all_of(component.vertices.begin(), component.vertices.end(), [&](std::uint32_t v) {
      const double squared =
          geometry::distance_to_triangle(geometry::to_vec3(at(v)), a, b, c, 2.0 * distance * distance + 1.0)
              .squared;
      return squared <= distance * distance;
    });
  }

  // What the component's vertices become: a corner of the triangle that stays, or else one of themselves,
  // that is within reach of all that they stand for. kNone when there is none.
  std::uint32_t heir_of(const Component& component, const Triangle& t) const {
    if (merged_.empty()) return t[0];
    const auto reaches = [&](std::uint32_t to) {
      return std::all_of(component.vertices.begin(), component.vertices.end(),
                         [&](std::uint32_t v) { return merged_[v].is_within(region_.reach, at(to)); });
    };
    std::array<std::uint32_t, 3> corners = t;
    const auto is_less = [&](std::uint32_t a, std::uint32_t b) { return at(a) < at(b); };
    std::sort(corners.begin(), corners.end(), is_less);
    for (const auto v : corners)
      if (reaches(v)) return v;
    std::vector<std::uint32_t> own = component.vertices;
    std::sort(own.begin(), own.end(), is_less);
    const auto found = std::find_if(own.begin(), own.end(), reaches);
    return found == own.end() ? kNone : *found;
  }

  void finish() {
    std::vector<std::uint32_t> orphans;
    for (std::uint32_t s = 0; s < region_.samples.size(); ++s)
      if (const std::uint32_t c = component_of_vertex_[region_.samples[s].anchor];
          c != kNone && components_[c].is_dropped)
        orphans.push_back(s);
    for (std::size_t i = 0; i < triangles().size(); ++i)
      if (components_[component_of_[i]].is_dropped) triangles()[i] = kDeadTriangle;
    drop_dead_triangles(region_);
    const std::vector<std::uint32_t> result = drop_dead_vertices(region_, std::move(becomes_));
    for (auto& v : representative_) v = result[v];
    for (SurfaceSample& sample : region_.samples) sample.anchor = result[sample.anchor];
    attach_to_nearest(region_.mesh, region_.cells, orphans, region_.samples);
    std::vector<std::uint32_t> component_of(region_.mesh.vertices.size(), kNone);
    for (std::size_t v = 0; v < result.size(); ++v)
      if (const std::uint32_t c = component_of_vertex_[v]; c != kNone && !components_[c].is_dropped)
        component_of[result[v]] = c;
    pin_one_each(component_of, orphans);
  }

  // Of the samples at each component that have been dropped components', the farthest: with it the
  // component's own corners say how far all of them are, by the triangle inequality.
  void pin_one_each(const std::vector<std::uint32_t>& component_of,
                    const std::vector<std::uint32_t>& orphans) {
    for (const auto s : orphans) region_.samples[s].is_pinned = 1;
    std::vector<std::uint32_t> pinned(components_.size(), kNone);
    for (std::uint32_t s = 0; s < region_.samples.size(); ++s) {
      SurfaceSample& sample = region_.samples[s];
      if (sample.is_pinned == 0 || component_of[sample.anchor] == kNone) continue;
      std::uint32_t& best = pinned[component_of[sample.anchor]];
      sample.is_pinned = 0;
      if (best == kNone || std::tuple(-sample.distance, sample.position) <
                               std::tuple(-region_.samples[best].distance, region_.samples[best].position))
        best = s;
    }
    for (const auto s : pinned)
      if (s != kNone) region_.samples[s].is_pinned = 1;
  }

  Region& region_;
  const std::vector<mesh::Vertex>& before_;
  std::vector<std::uint32_t>& representative_;
  std::vector<std::uint32_t> roots_;
  std::vector<std::uint32_t> component_of_;         // per triangle
  std::vector<std::uint32_t> component_of_vertex_;  // kNone without triangles
  std::vector<Component> components_;
  std::vector<Box> chunks_;
  std::vector<MergedBox> merged_;  // per vertex; empty without a reach
  std::vector<std::uint32_t> becomes_;
  double farthest_ = 0.0;
  std::uint64_t looked_at_ = 0;
};

}  // namespace

double drop_components(Region& region, std::size_t target, double limit,
                       const std::vector<mesh::Vertex>& before, std::vector<std::uint32_t>& representative) {
  if (region.mesh.triangles.size() <= target || !(limit > 0.0)) return 0.0;
  return ComponentDropper(region, before, representative).run(target, limit);
}

}  // namespace colossus::simplify
