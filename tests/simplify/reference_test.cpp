// Our kernel beside OpenMesh's.
#include <gtest/gtest.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <cmath>
#include <cstdio>
#include <random>

#include "simplify/brute_force.hpp"
#include "simplify/collapse.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

// Points spread evenly over a surface.
std::vector<Vec3> spread_points(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  std::vector<double> areas;
  for (const Triangle& t : mesh.triangles)
    areas.push_back(
        geometry::length(geometry::cross(at(mesh, t[1]) - at(mesh, t[0]), at(mesh, t[2]) - at(mesh, t[0]))));
  std::mt19937_64 random(seed);
  std::discrete_distribution<std::size_t> triangle(areas.begin(), areas.end());
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const Triangle& t = mesh.triangles[triangle(random)];
    double u = share(random);
    double v = share(random);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    points.push_back(at(mesh, t[0]) + u * (at(mesh, t[1]) - at(mesh, t[0])) +
                     v * (at(mesh, t[2]) - at(mesh, t[0])));
  }
  return points;
}

double rms_distance(const Mesh& from, const Mesh& to) {
  const BruteForce surface(to);
  double sum = 0.0;
  const auto points = spread_points(from, 4000, 1);
  for (const Vec3& p : points) {
    const double d = surface.distance(p);
    sum += d * d;
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

struct DoubleTraits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using ReferenceMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

Mesh decimated_by_open_mesh(const Mesh& mesh, std::size_t target_triangles) {
  ReferenceMesh reference;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3 p = at(mesh, v);
    reference.add_vertex({p.x, p.y, p.z});
  }
  for (const Triangle& t : mesh.triangles)
    reference.add_face(reference.vertex_handle(t[0]), reference.vertex_handle(t[1]),
                       reference.vertex_handle(t[2]));
  OpenMesh::Decimater::DecimaterT<ReferenceMesh> decimater(reference);
  OpenMesh::Decimater::ModQuadricT<ReferenceMesh>::Handle quadrics;
  decimater.add(quadrics);
  decimater.module(quadrics).unset_max_err();
  decimater.initialize();
  decimater.decimate_to_faces(0, target_triangles);
  reference.garbage_collection();
  Mesh result;
  for (const auto v : reference.vertices()) {
    const auto& p = reference.point(v);  // half-edge collapses: still lattice points
    result.vertices.push_back(vertex_at(
        {static_cast<std::int32_t>(p[0]), static_cast<std::int32_t>(p[1]), static_cast<std::int32_t>(p[2])}));
  }
  for (const auto f : reference.faces()) {
    Triangle triangle{};
    std::size_t corner = 0;
    for (const auto v : reference.fv_range(f)) triangle[corner++] = static_cast<std::uint32_t>(v.idx());
    result.triangles.push_back(triangle);
  }
  return result;
}

TEST(Simplify, IsNoFartherFromTheOriginalThanOpenMesh) {
  const Mesh original = sphere(4, 0.005, 10);
  for (const std::size_t divisor : {2U, 4U}) {
    const Mesh reference = decimated_by_open_mesh(original, original.triangles.size() / divisor);
    ASSERT_LE(reference.triangles.size(), original.triangles.size() / divisor + 2);
    Region region = make_region(original, {}, {});
    simplify(region, reference.triangles.size());
    ASSERT_LE(region.mesh.triangles.size(), reference.triangles.size());
    const double ours = rms_distance(region.mesh, original) / kRadius;
    const double theirs = rms_distance(reference, original) / kRadius;
    const double ours_back = rms_distance(original, region.mesh) / kRadius;
    const double theirs_back = rms_distance(original, reference) / kRadius;
    std::printf(
        "1/%zu: RMS to the original %.3e (OpenMesh %.3e), from it %.3e (OpenMesh %.3e) of the radius\n",
        divisor, ours, theirs, ours_back, theirs_back);
    EXPECT_LE(ours, theirs);
    EXPECT_LE(ours_back, theirs_back);
  }
}

}  // namespace
}  // namespace colossus::simplify
