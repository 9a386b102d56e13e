// Regions to simplify, made from generated meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.hpp"
#include "mesh/mesh.hpp"
#include "simplify/region.hpp"

namespace colossus::simplify {

using geometry::Plane;
using geometry::Point;
using geometry::Vec3;
using mesh::Mesh;
using mesh::Triangle;

constexpr std::int32_t kMiddle = geometry::kRootSide / 2;
constexpr double kRadius = 0.25 * geometry::kRootSide;
inline const Vec3 kCenter{kMiddle, kMiddle, kMiddle};

inline Vec3 at(const Mesh& mesh, std::uint32_t v) { return geometry::to_vec3(mesh.vertices[v].position); }

// At the residues of input vertices, so on no plane of the cells below.
Point input_point(const Vec3& p);

mesh::Vertex vertex_at(const Point& position);

// A geodesic sphere of 20 * 4^depth triangles facing outward, its vertices moved along the radius by up to
// `noise` of it.
Mesh sphere(int depth, double noise, std::uint64_t seed);

// A square of n * n squares over [low, high] in x and y, wavy in z everywhere, its border too.
Mesh wavy_grid(std::uint32_t n);

// A sheet of columns * rows squares of equal size, each with either diagonal, facing up: its vertices, those
// of the border too, moved sideways by up to 0.2 of a side and up or down by up to `height` sides.
Mesh rough_sheet(std::uint32_t columns, std::uint32_t rows, double height, std::uint64_t seed);

void append(Mesh& mesh, const Mesh& other);

// A task's region: what lies on the positive side of the outer planes, cut by the inner planes into a cell
// per combination of sides. Bit i of the masks is inner plane i, the outer ones follow. At most three planes
// in all.
Region make_region(const Mesh& mesh, const std::vector<Plane>& inner, const std::vector<Plane>& outer);

inline const std::vector<Plane> kInnerPlanes{{{1, 0, 0}, kMiddle}, {{0, 1, -1}, 0}};
inline const std::vector<Plane> kOuterPlanes{{{0, 0, 1}, kMiddle - kMiddle / 8}};
constexpr FaceMask kOuterFace = 4;

// Every triangle lies in its cell, faces included.
void expect_in_cells(const Region& region);

}  // namespace colossus::simplify
