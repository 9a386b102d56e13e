#include "pipeline/diamonds/cut_remains.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "geometry/lattice.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using geometry::Point;
using hierarchy::Tetrahedron;
using Segment = std::pair<Point, Point>;  // the lesser end first

bool lies_in_a_face(const Tetrahedron& tetrahedron, const Segment& segment) {
  for (int corner = 0; corner < 4; ++corner) {
    const geometry::Plane plane = tetrahedron.face_plane(corner);
    if (plane.side(segment.first) == 0 && plane.side(segment.second) == 0) return true;
  }
  return false;
}

bool is_strictly_inside(const Tetrahedron& tetrahedron, const Point& p) {
  for (int corner = 0; corner < 4; ++corner)
    if (tetrahedron.face_plane(corner).side(p) <= 0) return false;
  return true;
}

bool is_on_line(const Segment& segment, const Point& p) {
  std::array<std::int64_t, 3> a, b;
  for (int axis = 0; axis < 3; ++axis) {
    a[static_cast<std::size_t>(axis)] = std::int64_t{segment.second[axis]} - segment.first[axis];
    b[static_cast<std::size_t>(axis)] = std::int64_t{p[axis]} - segment.first[axis];
  }
  return a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2] && a[0] * b[1] == a[1] * b[0];
}

// Beside the middle of the segment.
std::optional<Point> third_corner(const Tetrahedron& tetrahedron, const Segment& segment) {
  for (int step = 1; step <= 4; ++step)
    for (int axis = 0; axis < 3; ++axis)
      for (const int sign : {1, -1}) {
        Point p;
        for (int k = 0; k < 3; ++k) {
          const std::int64_t middle = (std::int64_t{segment.first[k]} + segment.second[k]) / 2;
          p[k] = static_cast<std::int32_t>(middle / geometry::kInputSpacing * geometry::kInputSpacing) +
                 geometry::kInputResidue[static_cast<std::size_t>(k)];
        }
        p[axis] += sign * step * geometry::kInputSpacing / 4;
        if (is_strictly_inside(tetrahedron, p) && !is_on_line(segment, p)) return p;
      }
  return std::nullopt;
}

}  // namespace

std::uint64_t weld_cut(const Tetrahedron& tetrahedron, mesh::Mesh& mesh) {
  std::map<Segment, std::array<mesh::Vertex, 2>> segments;
  for (const mesh::Triangle& t : mesh.triangles) {
    std::array<mesh::Vertex, 3> corners{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    if (!mesh::is_degenerate(corners[0].position, corners[1].position, corners[2].position)) continue;
    std::sort(corners.begin(), corners.end(),
              [](const mesh::Vertex& a, const mesh::Vertex& b) { return a.position < b.position; });
    segments.try_emplace({corners[0].position, corners[2].position}, std::array{corners[0], corners[2]});
  }
  mesh::weld(mesh);
  if (segments.empty()) return 0;
  for (const mesh::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3 && !segments.empty(); ++k)
      segments.erase(std::minmax(mesh.vertices[t[k]].position, mesh.vertices[t[(k + 1) % 3]].position));
  std::unordered_map<Point, std::uint32_t, geometry::PointHash> numbers;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) numbers.try_emplace(mesh.vertices[v].position, v);
  const auto number_of = [&](const mesh::Vertex& vertex) {
    const auto [entry, is_new] =
        numbers.try_emplace(vertex.position, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(vertex);
    return entry->second;
  };
  std::uint64_t pairs = 0;
  for (const auto& [segment, ends] : segments) {
    if (lies_in_a_face(tetrahedron, segment)) continue;
    const auto third = third_corner(tetrahedron, segment);
    // Only in tetrahedra of some cells of the lattice: there the segment is within two cells of a face.
    if (!third) continue;
    mesh::Vertex beside = ends[0];
    beside.position = *third;
    const std::uint32_t a = number_of(ends[0]), b = number_of(ends[1]), c = number_of(beside);
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, b});
    ++pairs;
  }
  return pairs;
}

}  // namespace colossus::pipeline::diamonds
