#include "simplify/region.hpp"

#include "geometry/vector.hpp"

namespace colossus::simplify {

AngleCounts count_small_angles(const mesh::Mesh& mesh) {
  // Squared cosines, since the container's bytes may not depend on a library's arccosine.
  constexpr double kSquaredCos5 = 0.99240387650610395;
  constexpr double kSquaredCos15 = 0.93301270189221941;
  constexpr double kSquaredCos30 = 0.75;
  AngleCounts counts;
  for (const mesh::Triangle& t : mesh.triangles) {
    double greatest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const geometry::Vec3 p = geometry::to_vec3(mesh.vertices[t[k]].position);
      const geometry::Vec3 u = geometry::to_vec3(mesh.vertices[t[(k + 1) % 3]].position) - p;
      const geometry::Vec3 v = geometry::to_vec3(mesh.vertices[t[(k + 2) % 3]].position) - p;
      const double d = geometry::dot(u, v);
      const double lengths = geometry::squared_length(u) * geometry::squared_length(v);
      if (d > 0.0) greatest = std::max(greatest, lengths > 0.0 ? d * d / lengths : 1.0);
    }
    counts.below_5_degrees += greatest > kSquaredCos5 ? 1 : 0;
    counts.below_15_degrees += greatest > kSquaredCos15 ? 1 : 0;
    counts.below_30_degrees += greatest > kSquaredCos30 ? 1 : 0;
  }
  return counts;
}

}  // namespace colossus::simplify
