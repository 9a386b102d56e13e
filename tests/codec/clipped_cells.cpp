#include "codec/clipped_cells.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "mesh/clip.hpp"
#include "mesh/topology.hpp"

namespace colossus::codec {
namespace {

using geometry::Point;
using geometry::Vec3;
using hierarchy::Tetrahedron;
using mesh::Mesh;
using mesh::Triangle;

void descend(const Tetrahedron& tetrahedron, Mesh mesh, int levels, std::vector<Cell>& cells) {
  if (mesh.triangles.empty()) return;
  if (levels == 0) {
    mesh::weld(mesh);
    if (!mesh.triangles.empty()) cells.push_back({tetrahedron, std::move(mesh)});
    return;
  }
  auto halves = mesh::split(mesh, tetrahedron.bisector());
  for (const int end : {0, 1})
    descend(tetrahedron.child(end), std::move(halves[static_cast<std::size_t>(end)]), levels - 1, cells);
}

// What of the mesh lies on the same side of the plane as the tetrahedron.
Mesh side_of(const Mesh& mesh, const geometry::Plane& plane, const Tetrahedron& tetrahedron) {
  for (const Point& corner : tetrahedron.corners)
    if (const std::int64_t side = plane.side(corner); side != 0)
      return mesh::split(mesh, plane)[side > 0 ? 0 : 1];
  return {};
}

using Indices = std::map<coded::ScaledPosition, std::uint32_t>;

std::uint32_t index_of(Indices& indices, const coded::ScaledPosition& position) {
  return indices.try_emplace(position, static_cast<std::uint32_t>(indices.size())).first->second;
}

std::array<Point, 3> face_corners(const Tetrahedron& tetrahedron, std::size_t opposite) {
  std::array<Point, 3> corners{};
  for (std::size_t i = 0, k = 0; i < 4; ++i)
    if (i != opposite) corners[k++] = tetrahedron.corners[i];
  return corners;
}

std::int32_t rounded(double value, std::int32_t residue) {
  return (static_cast<std::int32_t>(value) & ~7) | residue;
}

}  // namespace

std::vector<Cell> clip_to_cells(const Mesh& mesh, int level) {
  std::vector<Cell> cells;
  const hierarchy::Diamond root = hierarchy::Diamond::at(hierarchy::root_center());
  for (int place = 0; place < root.place_count; ++place) {
    const Tetrahedron& tetrahedron = root.tetrahedra[static_cast<std::size_t>(place)];
    Mesh part = mesh;
    for (const geometry::Plane& plane : hierarchy::root_planes()) part = side_of(part, plane, tetrahedron);
    descend(tetrahedron, std::move(part), level, cells);
  }
  return cells;
}

SeenCell unquantised(const Cell& cell) {
  SeenCell seen{cell.tetrahedron, {}, {}, cell.mesh.triangles};
  for (const mesh::Vertex& vertex : cell.mesh.vertices) {
    seen.positions.push_back({vertex.position.x, vertex.position.y, vertex.position.z});
    std::uint8_t marks = 0;
    for (int i = 0; i < 4; ++i)
      if (cell.tetrahedron.face_plane(i).side(vertex.position) == 0)
        marks = static_cast<std::uint8_t>(marks | 1U << i);
    seen.marks.push_back(marks);
  }
  return seen;
}

SeenCell quantised(const Cell& cell, int bits) {
  const coded::CodedPart part =
      quantization::quantize(cell.mesh, cell.tetrahedron, 0, {bits, false, false}).tetrahedron;
  SeenCell seen{cell.tetrahedron, {}, coded::marks_of(part.positions), part.triangles};
  for (const coded::Weights& weights : part.positions)
    seen.positions.push_back(coded::scaled_position(weights, cell.tetrahedron));
  return seen;
}

EdgeCounts count_edges(const std::vector<SeenCell>& cells) {
  Indices indices;
  std::vector<Triangle> triangles;
  EdgeCounts counts;
  for (const SeenCell& cell : cells)
    for (const Triangle& t : cell.triangles) {
      const Triangle welded{index_of(indices, cell.positions[t[0]]), index_of(indices, cell.positions[t[1]]),
                            index_of(indices, cell.positions[t[2]])};
      if (welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0])
        triangles.push_back(welded);
      else
        ++counts.degenerate;
    }
  for (const mesh::Edge& edge : mesh::edges(triangles)) {
    counts.nonmanifold += edge.is_nonmanifold() ? 1 : 0;
    counts.unbalanced += edge.forward != edge.backward ? 1 : 0;
  }
  return counts;
}

FaceEdges compare_faces(const std::vector<SeenCell>& cells) {
  FaceEdges found;
  // Directions of each edge, net, of both sides together.
  std::map<std::array<Point, 3>, std::map<std::pair<coded::ScaledPosition, coded::ScaledPosition>, int>>
      faces;
  for (const SeenCell& cell : cells)
    for (const Triangle& t : cell.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k];
        const std::uint32_t b = t[(k + 1) % 3];
        const unsigned common = cell.marks[a] & cell.marks[b];
        for (std::size_t i = 0; i < 4; ++i) {
          if (common != 1U << i) continue;
          const auto [low, high] = std::minmax(cell.positions[a], cell.positions[b]);
          faces[face_corners(cell.tetrahedron, i)][{low, high}] += cell.positions[a] == low ? 1 : -1;
          ++found.count;
        }
      }
  for (const auto& [face, edges] : faces)
    for (const auto& [ends, net] : edges) found.differing += net != 0 ? 1 : 0;
  return found;
}

Mesh ellipsoid(Random& random, const Vec3& center, const std::array<Vec3, 3>& half_axes,
               std::uint32_t segments, double noise) {
  std::uniform_real_distribution<double> length(1.0 - noise, 1.0 + noise);
  Mesh mesh;
  const auto add = [&](double u, double v, double w) {
    const Vec3 p = center + length(random) * (u * half_axes[0] + v * half_axes[1] + w * half_axes[2]);
    mesh::Vertex vertex;
    vertex.position = {rounded(p.x, 1), rounded(p.y, 2), rounded(p.z, 4)};
    mesh.vertices.push_back(vertex);
  };
  const std::uint32_t rings = segments;
  const double half_turn = std::acos(-1.0);
  add(-1.0, 0.0, 0.0);
  for (std::uint32_t ring = 1; ring <= rings; ++ring)
    for (std::uint32_t k = 0; k < segments; ++k) {
      const double latitude = half_turn * ring / (rings + 1);
      const double longitude = half_turn * (2 * k + ring % 2) / segments;
      add(-std::cos(latitude), std::sin(latitude) * std::cos(longitude),
          std::sin(latitude) * std::sin(longitude));
    }
  add(1.0, 0.0, 0.0);
  const auto at = [&](std::uint32_t ring, std::uint32_t k) { return 1 + ring * segments + k % segments; };
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (std::uint32_t k = 0; k < segments; ++k) {
    mesh.triangles.push_back({0, at(0, k + 1), at(0, k)});
    for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k)});
      mesh.triangles.push_back({at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)});
    }
    mesh.triangles.push_back({at(rings - 1, k), at(rings - 1, k + 1), last});
  }
  return mesh;
}

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

Mesh shuffled(const Mesh& mesh, Random& random) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), random);
  Mesh result;
  result.vertices.resize(mesh.vertices.size());
  for (std::size_t v = 0; v < order.size(); ++v) result.vertices[order[v]] = mesh.vertices[v];
  for (const Triangle& t : mesh.triangles) {
    result.triangles.push_back({order[t[0]], order[t[1]], order[t[2]]});
    std::rotate(result.triangles.back().begin(),
                result.triangles.back().begin() + static_cast<std::ptrdiff_t>(random() % 3),
                result.triangles.back().end());
  }
  std::shuffle(result.triangles.begin(), result.triangles.end(), random);
  return result;
}

}  // namespace colossus::codec
