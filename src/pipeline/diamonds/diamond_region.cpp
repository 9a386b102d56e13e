#include "pipeline/diamonds/diamond_region.hpp"

#include <algorithm>

namespace colossus::pipeline::diamonds {
namespace {

using hierarchy::Diamond;
using hierarchy::Point;
using hierarchy::Tetrahedron;

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr std::size_t kFirstOuterBit = 8;

// The corners of the diamond that are no ends of its long edge, in order: inner face i holds the long edge
// and ring[i].
std::vector<Point> ring_of(const Diamond& diamond) {
  std::vector<Point> ring;
  for (int place = 0; place < diamond.place_count; ++place)
    for (const Point& corner : diamond.tetrahedra[static_cast<std::size_t>(place)].corners)
      if (corner != diamond.ends[0] && corner != diamond.ends[1]) ring.push_back(corner);
  std::sort(ring.begin(), ring.end());
  ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  return ring;
}

// For each tetrahedron and each of its corners, the bit of the face opposite that corner.
std::array<std::array<simplify::FaceMask, 4>, 8> face_bits(const Diamond& diamond) {
  const std::vector<Point> ring = ring_of(diamond);
  std::array<std::array<simplify::FaceMask, 4>, 8> bits{};
  for (std::size_t place = 0; place < static_cast<std::size_t>(diamond.place_count); ++place) {
    const Tetrahedron& t = diamond.tetrahedra[place];
    for (std::size_t corner = 0; corner < 4; ++corner) {
      std::size_t bit = 0;
      if (t.corners[corner] == diamond.ends[0] || t.corners[corner] == diamond.ends[1]) {
        bit = kFirstOuterBit + 2 * place + (t.corners[corner] == diamond.ends[0] ? 0 : 1);
      } else {
        for (const Point& other : t.corners)
          if (other != t.corners[corner] && other != diamond.ends[0] && other != diamond.ends[1])
            bit = static_cast<std::size_t>(std::lower_bound(ring.begin(), ring.end(), other) - ring.begin());
      }
      bits[place][corner] = simplify::FaceMask{1} << bit;
    }
  }
  return bits;
}

}  // namespace

simplify::Region make_region(const Diamond& diamond, std::span<const PlacedMesh> parts) {
  simplify::Region region;
  const auto bits = face_bits(diamond);
  for (std::size_t bit = kFirstOuterBit; bit < kFirstOuterBit + 16; ++bit)
    region.outer_faces |= simplify::FaceMask{1} << bit;
  for (int place = 0; place < diamond.place_count; ++place) {
    std::array<geometry::Plane, 4> planes;
    for (int corner = 0; corner < 4; ++corner)
      planes[static_cast<std::size_t>(corner)] =
          diamond.tetrahedra[static_cast<std::size_t>(place)].face_plane(corner);
    region.cell_planes.push_back(planes);
  }
  std::vector<mesh::Vertex> vertices;
  std::vector<simplify::FaceMask> faces;
  std::vector<mesh::Triangle> triangles;
  for (const PlacedMesh& part : parts) {
    const auto base = static_cast<std::uint32_t>(vertices.size());
    const mesh::Mesh& mesh = part.content.mesh;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      simplify::FaceMask mask = 0;
      for (std::size_t corner = 0; corner < 4; ++corner)
        if (region.cell_planes[part.place][corner].side(mesh.vertices[v].position) == 0)
          mask |= bits[part.place][corner];
      vertices.push_back(mesh.vertices[v]);
      faces.push_back(mask);
    }
    for (simplify::SurfaceSample sample : part.content.samples) {
      sample.anchor += base;
      region.samples.push_back(sample);
    }
    for (const mesh::Triangle& t : mesh.triangles) {
      triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
      region.cells.push_back(static_cast<std::uint16_t>(part.place));
    }
  }
  const std::vector<std::uint32_t> remap = mesh::position_remap(vertices);
  std::vector<std::uint32_t> renumbered(vertices.size(), kNone);
  for (std::uint32_t v = 0; v < vertices.size(); ++v) {
    if (remap[v] == v) {
      renumbered[v] = static_cast<std::uint32_t>(region.mesh.vertices.size());
      region.mesh.vertices.push_back(vertices[v]);
      region.faces.push_back(0);
    }
    const std::uint32_t to = renumbered[remap[v]];
    region.faces[to] |= faces[v];
  }
  for (mesh::Triangle& t : triangles)
    for (auto& v : t) v = renumbered[remap[v]];
  region.mesh.triangles = std::move(triangles);
  for (simplify::SurfaceSample& sample : region.samples) sample.anchor = renumbered[remap[sample.anchor]];
  return region;
}

std::vector<PlacedMesh> split_region(const simplify::Region& region, const Diamond& diamond) {
  std::vector<PlacedMesh> parts;
  std::vector<std::uint32_t> renumbered(region.mesh.vertices.size());
  for (std::uint32_t place = 0; place < static_cast<std::uint32_t>(diamond.place_count); ++place) {
    PlacedMesh part;
    part.place = place;
    std::fill(renumbered.begin(), renumbered.end(), kNone);
    for (std::size_t i = 0; i < region.mesh.triangles.size(); ++i) {
      if (region.cells[i] != place) continue;
      mesh::Triangle t = region.mesh.triangles[i];
      for (auto& v : t) {
        if (renumbered[v] == kNone) {
          renumbered[v] = static_cast<std::uint32_t>(part.content.mesh.vertices.size());
          part.content.mesh.vertices.push_back(region.mesh.vertices[v]);
        }
        v = renumbered[v];
      }
      part.content.mesh.triangles.push_back(t);
    }
    for (simplify::SurfaceSample sample : region.samples) {
      if (sample.cell != place) continue;
      sample.anchor = renumbered[sample.anchor];
      part.content.samples.push_back(sample);
    }
    if (!part.content.mesh.triangles.empty()) parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace colossus::pipeline::diamonds
