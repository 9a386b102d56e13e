#include "torus.hpp"

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "geometry/lattice.hpp"

namespace colossus::bench {
namespace {

// The centre of the sphere inside the cell, and radii that stay within it, as parts of the root's side.
constexpr std::array<double, 3> kCenter{0.793, 0.5, 0.207};
constexpr double kMajorRadius = 0.12;
constexpr double kMinorRadius = 0.06;

double noise(std::uint64_t seed) { return static_cast<double>(core::mix64(seed) >> 11) * 0x1p-52 - 1.0; }

std::int32_t on_input_lattice(double part, int axis) {
  const auto cells = static_cast<std::int32_t>(part * geometry::kRootSide / geometry::kInputSpacing);
  return cells * geometry::kInputSpacing + geometry::kInputResidue[static_cast<std::size_t>(axis)];
}

mesh::Vertex vertex_at(std::uint32_t i, std::uint32_t j, std::uint32_t rings,
                       const hierarchy::Tetrahedron& tetrahedron) {
  const double u = std::numbers::pi * i / rings;
  const double v = 2.0 * std::numbers::pi * j / rings;
  const double edge = 2.0 * std::numbers::pi * kMinorRadius / rings;
  double radius = kMinorRadius + 0.1 * edge * noise(std::uint64_t{i} << 32 | j);
  for (const int octave : {5, 17, 41})
    radius += 0.02 / octave * std::sin(octave * 2.0 * u) * std::cos(octave * v);
  const double out = kMajorRadius + radius * std::cos(v);
  const std::array<double, 3> parts{kCenter[0] + out * std::cos(2.0 * u),
                                    kCenter[1] + out * std::sin(2.0 * u), kCenter[2] + radius * std::sin(v)};
  mesh::Vertex vertex;
  for (int axis = 0; axis < 3; ++axis)
    vertex.position[axis] = on_input_lattice(parts[static_cast<std::size_t>(axis)], axis);
  vertex.color = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j),
                  static_cast<std::uint8_t>(i ^ j), 255};
  COLOSSUS_CHECK(tetrahedron.contains(vertex.position), "the torus leaves its cell");
  return vertex;
}

}  // namespace

hierarchy::Tetrahedron cell() {
  // x >= y >= z: the place of the sphere of kCenter.
  constexpr std::int32_t s = geometry::kRootSide;
  return {{{{0, 0, 0}, {s, 0, 0}, {s, s, 0}, {s, s, s}}}};
}

mesh::Mesh torus(std::uint32_t rings) {
  const hierarchy::Tetrahedron tetrahedron = cell();
  mesh::Mesh result;
  const std::uint32_t around = 2 * rings;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < rings; ++j) {
      result.vertices.push_back(vertex_at(i, j, rings, tetrahedron));
      const std::uint32_t a = i * rings + j;
      const std::uint32_t b = i * rings + (j + 1) % rings;
      const std::uint32_t c = (i + 1) % around * rings + j;
      const std::uint32_t d = (i + 1) % around * rings + (j + 1) % rings;
      result.triangles.push_back({a, c, b});
      result.triangles.push_back({b, c, d});
    }
  return result;
}

simplify::Region region_of(const mesh::Mesh& mesh, std::size_t sample_count) {
  simplify::Region region;
  region.mesh = mesh;
  region.faces.assign(mesh.vertices.size(), 0);
  region.cells.assign(mesh.triangles.size(), 0);
  const hierarchy::Tetrahedron tetrahedron = cell();
  region.cell_planes.push_back({tetrahedron.face_plane(0), tetrahedron.face_plane(1),
                                tetrahedron.face_plane(2), tetrahedron.face_plane(3)});
  for (std::size_t i = 0; i < sample_count; ++i) {
    const std::size_t v = i * mesh.vertices.size() / sample_count;
    region.samples.push_back({mesh.vertices[v].position, static_cast<std::uint32_t>(v), 0.0F, 0});
  }
  return region;
}

}  // namespace colossus::bench
