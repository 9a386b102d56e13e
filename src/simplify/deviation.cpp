#include "simplify/deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/vector.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/topology.hpp"

namespace colossus::simplify {
namespace {

using geometry::Vec3;

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr double kFar = std::numeric_limits<double>::infinity();

struct Nearest {
  double squared = kFar;
  std::uint32_t triangle = kNone;
  bool is_inside = false;  // a projection within the triangle, not a point of its rim
};

// A surface on which the nearest point is found by walking.
class WalkableSurface {
 public:
  explicit WalkableSurface(const mesh::Mesh& mesh) : mesh_(mesh) {
    adjacency_.build(mesh.triangles, mesh.vertices.size());
    stamps_.assign(mesh.vertices.size(), 0);
  }

  // The nearest of the triangles around v, if nearer than what is known. Content with one within
  // `squared_enough`.
  void look_around(const Vec3& p, std::uint32_t v, Nearest& nearest, double squared_enough = -1.0) const {
    for (const auto i : adjacency_.around(v)) {
      if (nearest.squared <= squared_enough) return;
      const mesh::Triangle& t = mesh_.triangles[i];
      const auto found = geometry::distance_to_triangle(p, at(t[0]), at(t[1]), at(t[2]), nearest.squared);
      if (found.squared < nearest.squared) nearest = {found.squared, i, found.is_inside};
    }
  }

  // From v on to wherever it gets nearer, until p projects into a triangle. A local minimum: an upper bound
  // of the distance.
  Nearest walk(const Vec3& p, std::uint32_t v, double squared_enough = -1.0) {
    const std::uint32_t visited = ++stamp_;
    Nearest nearest;
    stamps_[v] = visited;
    look_around(p, v, nearest, squared_enough);
    for (std::uint32_t from = kNone;
         nearest.triangle != from && !nearest.is_inside && nearest.squared > squared_enough;) {
      from = nearest.triangle;
      for (const auto corner : mesh_.triangles[from]) {
        if (stamps_[corner] == visited) continue;
        stamps_[corner] = visited;
        look_around(p, corner, nearest, squared_enough);
      }
    }
    return nearest;
  }

  // The nearest of all triangles, if nearer than what is known; the first of several. Linear, but most
  // triangles are passed over by the box of their chunk.
  void look_everywhere(const Vec3& p, Nearest& nearest) {
    if (chunks_.empty()) build_chunks();
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
      if (chunks_[c].squared_distance(p) > nearest.squared) continue;
      const std::size_t end = std::min((c + 1) * kChunkTriangles, mesh_.triangles.size());
      for (std::size_t i = c * kChunkTriangles; i < end; ++i) {
        const mesh::Triangle& t = mesh_.triangles[i];
        const auto found = geometry::distance_to_triangle(p, at(t[0]), at(t[1]), at(t[2]), nearest.squared);
        if (found.squared < nearest.squared)
          nearest = {found.squared, static_cast<std::uint32_t>(i), found.is_inside};
      }
    }
  }

  std::uint32_t nearest_corner(const Vec3& p, std::uint32_t triangle) const {
    const mesh::Triangle& t = mesh_.triangles[triangle];
    std::size_t best = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (geometry::squared_length(at(t[k]) - p) < geometry::squared_length(at(t[best]) - p)) best = k;
    return t[best];
  }

 private:
  // Neighbours in the list are mostly neighbours in space.
  static constexpr std::size_t kChunkTriangles = 32;
  struct Chunk {
    Vec3 low{kFar, kFar, kFar};
    Vec3 high{-kFar, -kFar, -kFar};

    void add(const Vec3& p) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    // What rounding may take off a triangle's distance.
    void widen() {
      const Vec3 margin = 1e-6 * (high - low);
      low = low - margin;
      high = high + margin;
    }
    double squared_distance(const Vec3& p) const {
      const auto beyond = [](double at, double from, double to) {
        return std::max({from - at, at - to, 0.0});
      };
      return geometry::squared_length(
          {beyond(p.x, low.x, high.x), beyond(p.y, low.y, high.y), beyond(p.z, low.z, high.z)});
    }
  };

  void build_chunks() {
    chunks_.resize((mesh_.triangles.size() + kChunkTriangles - 1) / kChunkTriangles);
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i)
      for (const auto v : mesh_.triangles[i]) chunks_[i / kChunkTriangles].add(at(v));
    for (Chunk& chunk : chunks_) chunk.widen();
  }

  Vec3 at(std::uint32_t v) const { return geometry::to_vec3(mesh_.vertices[v].position); }

  const mesh::Mesh& mesh_;
  mesh::Adjacency adjacency_;
  std::vector<std::uint32_t> stamps_;
  std::uint32_t stamp_ = 0;
  std::vector<Chunk> chunks_;  // made when first needed
};

void attach(SurfaceSample& sample, const Nearest& nearest, const WalkableSurface& surface,
            std::span<const std::uint16_t> cells) {
  sample.distance = static_cast<float>(std::sqrt(nearest.squared));
  sample.anchor = surface.nearest_corner(geometry::to_vec3(sample.position), nearest.triangle);
  sample.cell = cells[nearest.triangle];
}

// Where nothing is left of the surface but vertices. Returns the greatest distance.
double measure_to_representatives(const mesh::Mesh& after, std::span<const std::uint32_t> representative,
                                  std::vector<SurfaceSample>& samples) {
  double farthest = 0.0;
  for (SurfaceSample& sample : samples) {
    sample.anchor = representative[sample.anchor];
    const Vec3 to = geometry::to_vec3(after.vertices[sample.anchor].position);
    sample.distance = static_cast<float>(geometry::length(to - geometry::to_vec3(sample.position)));
    farthest = std::max(farthest, static_cast<double>(sample.distance));
  }
  return farthest;
}

// A walk does not find another sheet that is nearer. Only the farthest samples matter: they are measured
// against all triangles until one of them stays the farthest. Returns its distance.
double correct_farthest(WalkableSurface& surface, std::span<const std::uint16_t> cells,
                        std::vector<SurfaceSample>& samples) {
  constexpr int kMostCorrections = 100;
  struct Entry {
    float distance;
    std::uint32_t sample;
    bool is_exact;
  };
  const auto is_nearer = [](const Entry& a, const Entry& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.sample < b.sample;
  };
  std::vector<Entry> heap;
  for (std::uint32_t i = 0; i < samples.size(); ++i) heap.push_back({samples[i].distance, i, false});
  std::make_heap(heap.begin(), heap.end(), is_nearer);
  for (int round = 0; round < kMostCorrections && !heap.empty() && !heap.front().is_exact; ++round) {
    std::pop_heap(heap.begin(), heap.end(), is_nearer);
    SurfaceSample& sample = samples[heap.back().sample];
    // A little more than what the walk found, so that it is found again.
    Nearest nearest;
    nearest.squared =
        (1.0 + 1e-6) * static_cast<double>(sample.distance) * static_cast<double>(sample.distance) +
        std::numeric_limits<double>::min();
    surface.look_everywhere(geometry::to_vec3(sample.position), nearest);
    if (nearest.triangle != kNone) attach(sample, nearest, surface, cells);
    heap.back() = {sample.distance, heap.back().sample, true};
    std::push_heap(heap.begin(), heap.end(), is_nearer);
  }
  return heap.empty() ? 0.0 : static_cast<double>(heap.front().distance);
}

// From the input to the surface. Returns the greatest distance of a sample.
double measure_samples(const mesh::Mesh& after, std::span<const std::uint16_t> cells,
                       std::span<const std::uint32_t> representative, std::vector<SurfaceSample>& samples) {
  if (after.triangles.empty()) return measure_to_representatives(after, representative, samples);
  WalkableSurface surface(after);
  for (SurfaceSample& sample : samples) {
    const Vec3 p = geometry::to_vec3(sample.position);
    Nearest nearest = surface.walk(p, representative[sample.anchor]);
    // No triangle is left around this vertex.
    if (nearest.triangle == kNone) surface.look_everywhere(p, nearest);
    attach(sample, nearest, surface, cells);
  }
  return correct_farthest(surface, cells, samples);
}

// From the surface to the one that it was made of, and on to the input by what that one deviated there.
class WayBack {
 public:
  // `earlier`: what the samples said of the surface before, where each of its vertices was. Places that are no
  // farther than `known` need not be measured.
  WayBack(const mesh::Mesh& before, const mesh::Mesh& after, std::span<const std::uint32_t> representative,
          std::span<const float> earlier, double known)
      : before_(before),
        after_(after),
        representative_(representative),
        known_(known),
        surface_before_(before),
        carried_(after.vertices.size(), 0.0F),
        origin_(after.vertices.size(), kNone),
        placed_(find_origins(earlier)) {}

  // To the triangles around all vertices that have become this one.
  void measure_vertices() {
    for (std::uint32_t v = 0; v < before_.vertices.size(); ++v) {
      const std::uint32_t r = representative_[v];
      if (placed_[r].squared > 0.0)
        surface_before_.look_around(geometry::to_vec3(after_.vertices[r].position), v, placed_[r]);
    }
    for (std::size_t r = 0; r < placed_.size(); ++r)
      if (placed_[r].squared > 0.0)
        farthest_ = std::max(farthest_, std::sqrt(placed_[r].squared) + static_cast<double>(carried_[r]));
  }

  void measure_middles() {
    for (const mesh::Triangle& t : after_.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        // From both sides an edge inside the surface would be measured twice.
        if (t[k] < t[(k + 1) % 3]) measure_edge(t[k], t[(k + 1) % 3], 0.5);
  }

  void measure_border() {
    for (const mesh::Edge& edge : mesh::edges(after_.triangles))
      if (edge.is_border())
        for (const double at : {0.25, 0.5, 0.75}) measure_edge(edge.a, edge.b, at);
  }

  double farthest() const { return farthest_; }

 private:
  // Where each vertex comes from, and what it carries. Returns the distances that this tells: 0 to whoever
  // has stayed where it was.
  std::vector<Nearest> find_origins(std::span<const float> earlier) {
    std::vector<Nearest> placed(after_.vertices.size());
    for (std::uint32_t v = 0; v < before_.vertices.size(); ++v) {
      const std::uint32_t r = representative_[v];
      carried_[r] = std::max(carried_[r], earlier[v]);
      const bool is_still_there = before_.vertices[v].position == after_.vertices[r].position;
      if (is_still_there) placed[r].squared = 0.0;
      if (is_still_there || placed[r].squared > 0.0) origin_[r] = v;
    }
    return placed;
  }

  // At this share of the way from a to b. Only where a first look does not show that it is no farther than
  // what is known.
  void measure_edge(std::uint32_t a, std::uint32_t b, double at) {
    const Vec3 from = geometry::to_vec3(after_.vertices[a].position);
    const Vec3 p = from + at * (geometry::to_vec3(after_.vertices[b].position) - from);
    const double before_it = static_cast<double>(std::max(carried_[a], carried_[b]));
    const double known = std::max(known_, farthest_) - before_it;
    const double squared_enough = known > 0.0 ? known * known : -1.0;
    Nearest nearest;
    for (const auto end : {a, b}) {
      surface_before_.look_around(p, origin_[end], nearest, squared_enough);
      if (nearest.squared <= squared_enough) return;
    }
    for (const auto end : {a, b}) {
      const Nearest found = surface_before_.walk(p, origin_[end], squared_enough);
      if (found.squared < nearest.squared) nearest = found;
      if (nearest.squared <= squared_enough) return;
    }
    surface_before_.look_everywhere(p, nearest);
    farthest_ = std::max(farthest_, std::sqrt(nearest.squared) + before_it);
  }

  const mesh::Mesh& before_;
  const mesh::Mesh& after_;
  std::span<const std::uint32_t> representative_;
  double known_;
  double farthest_ = 0.0;
  WalkableSurface surface_before_;
  std::vector<float> carried_;         // the greatest that the samples said where it comes from
  std::vector<std::uint32_t> origin_;  // a vertex of `before` that has become this one
  std::vector<Nearest> placed_;        // 0 for who has stayed where it was
};

}  // namespace

Deviation measure_deviation(const mesh::Mesh& before, const mesh::Mesh& after,
                            std::span<const std::uint16_t> cells,
                            std::span<const std::uint32_t> representative, bool has_border,
                            std::vector<SurfaceSample>& samples) {
  std::vector<float> earlier(before.vertices.size(), 0.0F);
  for (const SurfaceSample& sample : samples)
    earlier[sample.anchor] = std::max(earlier[sample.anchor], sample.distance);

  Deviation deviation;
  deviation.of_samples = measure_samples(after, cells, representative, samples);
  if (after.triangles.empty()) return deviation;
  WayBack back(before, after, representative, earlier, deviation.of_samples);
  back.measure_vertices();
  back.measure_middles();
  if (has_border) back.measure_border();
  deviation.of_surface = back.farthest();
  return deviation;
}

void attach_to_nearest(const mesh::Mesh& mesh, std::span<const std::uint16_t> cells,
                       std::span<const std::uint32_t> which, std::vector<SurfaceSample>& samples) {
  WalkableSurface surface(mesh);
  for (const auto s : which) {
    Nearest nearest;
    surface.look_everywhere(geometry::to_vec3(samples[s].position), nearest);
    attach(samples[s], nearest, surface, cells);
  }
}

void thin_out(std::vector<SurfaceSample>& samples, std::size_t count) {
  const auto free_begin = std::stable_partition(samples.begin(), samples.end(),
                                                [](const SurfaceSample& s) { return s.is_pinned != 0; });
  if (static_cast<std::size_t>(samples.end() - free_begin) <= count) return;
  const auto farther = [](const SurfaceSample& a, const SurfaceSample& b) {
    return a.distance != b.distance ? a.distance > b.distance : a.position < b.position;
  };
  const auto by_hash = [](const SurfaceSample& a, const SurfaceSample& b) {
    const std::size_t hash_a = geometry::PointHash{}(a.position);
    const std::size_t hash_b = geometry::PointHash{}(b.position);
    return hash_a != hash_b ? hash_a < hash_b : a.position < b.position;
  };
  const auto kept = static_cast<std::ptrdiff_t>(count / 4);
  std::nth_element(free_begin, free_begin + kept, samples.end(), farther);
  std::nth_element(free_begin + kept, free_begin + static_cast<std::ptrdiff_t>(count), samples.end(),
                   by_hash);
  samples.erase(free_begin + static_cast<std::ptrdiff_t>(count), samples.end());
  // nth_element leaves an order of its own; this one is everybody's.
  std::sort(samples.begin(), samples.end(), [](const SurfaceSample& a, const SurfaceSample& b) {
    return a.anchor != b.anchor ? a.anchor < b.anchor : a.position < b.position;
  });
}

}  // namespace colossus::simplify
