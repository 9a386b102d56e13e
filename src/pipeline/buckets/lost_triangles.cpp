#include "pipeline/buckets/lost_triangles.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <unordered_map>
#include <utility>

namespace colossus::pipeline::buckets {
namespace {

using geometry::Point;

// The ends in order; equal where all three corners fell together.
using Segment = std::pair<Point, Point>;

class Reviver {
 public:
  Reviver(const std::vector<LostTriangle>& lost, std::int32_t spacing, const CubeId& cube, mesh::Mesh& mesh)
      : spacing_(spacing), cube_(cube), mesh_(mesh) {
    for (const LostTriangle& triangle : lost) {
      if (triangle.is_fin())
        fins_.push_back(
            {triangle.corners[0].position, triangle.corners[1].position, triangle.corners[2].position});
      else
        add(triangle);
    }
  }

  Revived run() {
    Revived revived{0, mesh_.triangles.size()};
    if (segments_.empty()) return revived;
    drop_covered();
    for (const auto& [segment, ends] : segments_) {
      // Who does not hold a point does not know whether the surface goes on there.
      if (segment.first == segment.second && !cube_.contains(segment.first, geometry::kRootBits)) continue;
      add_pair(segment, ends);
      revived.pairs += cube_.contains(segment.first, geometry::kRootBits) ? 1 : 0;
    }
    return revived;
  }

 private:
  void add(const LostTriangle& triangle) {
    std::array<mesh::Vertex, 3> corners = triangle.corners;
    std::sort(corners.begin(), corners.end(),
              [](const mesh::Vertex& a, const mesh::Vertex& b) { return a.position < b.position; });
    // Corners at one position have one set of attributes.
    segments_.try_emplace({corners[0].position, corners[2].position}, std::array{corners[0], corners[2]});
  }

  // A segment that is an edge of a triangle, a point that is a corner of one or an end of a segment.
  void drop_covered() {
    for (const auto& [segment, ends] : segments_)
      for (const Point& end : {segment.first, segment.second}) is_corner_.try_emplace(end, false);
    for (const mesh::Triangle& t : mesh_.triangles)
      cover({mesh_.vertices[t[0]].position, mesh_.vertices[t[1]].position, mesh_.vertices[t[2]].position});
    // What lies on a fin is no farther from the rest than that.
    for (const std::array<Point, 3>& fin : fins_) cover(fin);
    for (const auto& [segment, ends] : segments_)
      if (segment.first != segment.second) is_corner_[segment.first] = is_corner_[segment.second] = true;
    std::erase_if(segments_, [&](const auto& entry) {
      return entry.first.first == entry.first.second && is_corner_[entry.first.first];
    });
  }

  void cover(const std::array<Point, 3>& corners) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at_corner = is_corner_.find(corners[k]);
      if (at_corner == is_corner_.end()) continue;
      at_corner->second = true;
      segments_.erase(std::minmax(corners[k], corners[(k + 1) % 3]));
      segments_.erase(std::minmax(corners[k], corners[(k + 2) % 3]));
    }
  }

  void add_pair(const Segment& segment, const std::array<mesh::Vertex, 2>& ends) {
    const std::uint32_t a = number_of(ends[0]);
    std::uint32_t b = 0, c = 0;
    if (segment.first == segment.second) {
      b = number_of(beside(ends[0], 0));
      c = number_of(beside(ends[0], 1));
    } else {
      b = number_of(ends[1]);
      // Along the axis on which the segment extends least: never on its line.
      int axis = 0;
      const auto along = [&](int k) { return std::abs(std::int64_t{segment.first[k]} - segment.second[k]); };
      for (const int k : {1, 2})
        if (along(k) < along(axis)) axis = k;
      c = number_of(beside(ends[0], axis));
    }
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangles.push_back({a, c, b});
  }

  mesh::Vertex beside(mesh::Vertex vertex, int axis) const {
    vertex.position[axis] += spacing_;
    return vertex;
  }

  std::uint32_t number_of(const mesh::Vertex& vertex) {
    if (numbers_.empty())
      for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v)
        numbers_.try_emplace(mesh_.vertices[v].position, v);
    const auto [entry, is_new] =
        numbers_.try_emplace(vertex.position, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) mesh_.vertices.push_back(vertex);
    return entry->second;
  }

  std::int32_t spacing_;
  const CubeId& cube_;
  mesh::Mesh& mesh_;
  std::vector<std::array<Point, 3>> fins_;
  std::map<Segment, std::array<mesh::Vertex, 2>> segments_;
  std::unordered_map<Point, bool, geometry::PointHash> is_corner_;  // of ends: whether a triangle is there
  std::unordered_map<Point, std::uint32_t, geometry::PointHash> numbers_;
};

}  // namespace

Revived revive_lost(const std::vector<LostTriangle>& lost, std::int32_t spacing, const CubeId& cube,
                    mesh::Mesh& mesh) {
  return Reviver(lost, spacing, cube, mesh).run();
}

}  // namespace colossus::pipeline::buckets
