#include <gtest/gtest.h>

#include "geometry/octahedral.hpp"
#include "simplify/collapse.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

// Red, green and blue grow with x, y and z, from 0 to 255 over the sphere.
Vec3 color_of(const Vec3& from_center) {
  return (127.5 / kRadius) * (from_center + Vec3{kRadius, kRadius, kRadius});
}

TEST(Simplify, ColorsAndNormalsFollowTheVertices) {
  Mesh original = sphere(4, 0.0, 11);
  for (mesh::Vertex& vertex : original.vertices) {
    const Vec3 from_center = geometry::to_vec3(vertex.position) - kCenter;
    const Vec3 color = color_of(from_center);
    vertex.color = {static_cast<std::uint8_t>(color.x + 0.5), static_cast<std::uint8_t>(color.y + 0.5),
                    static_cast<std::uint8_t>(color.z + 0.5), 255};
    vertex.normal = geometry::to_normal16(from_center.x, from_center.y, from_center.z);
  }
  Region region = make_region(original, {}, {});
  simplify(region, original.triangles.size() / 8);
  double color_error = 0.0;
  double normal_error = 0.0;
  for (const mesh::Vertex& vertex : region.mesh.vertices) {
    const Vec3 from_center = geometry::to_vec3(vertex.position) - kCenter;
    const auto& [red, green, blue, alpha] = vertex.color;
    color_error += geometry::length(Vec3{1.0 * red, 1.0 * green, 1.0 * blue} - color_of(from_center));
    EXPECT_EQ(alpha, 255);
    const Vec3 normal{1.0 * vertex.normal[0], 1.0 * vertex.normal[1], 1.0 * vertex.normal[2]};
    normal_error += geometry::length(geometry::cross(normal, from_center)) / geometry::length(normal) /
                    geometry::length(from_center);
  }
  const auto count = static_cast<double>(region.mesh.vertices.size());
  // Interpolated along the wrong way, or taken from one end, they are off by twice as much at least.
  EXPECT_LT(color_error, 2.0 * count);
  EXPECT_LT(normal_error, 0.01 * count);
}

}  // namespace
}  // namespace colossus::simplify
