// Distances by brute force, independent of geometry/vector.hpp's.
#pragma once

#include <array>
#include <vector>

#include "geometry/vector.hpp"
#include "mesh/mesh.hpp"

namespace colossus::simplify {

double distance_to_triangle(const geometry::Vec3& p, const geometry::Vec3& a, const geometry::Vec3& b,
                            const geometry::Vec3& c);

// All triangles of a mesh, each in a ball so that most need no closer look.
class BruteForce {
 public:
  explicit BruteForce(const mesh::Mesh& mesh);
  double distance(const geometry::Vec3& p) const;

 private:
  struct Ball {
    std::array<geometry::Vec3, 3> corners;
    geometry::Vec3 middle;
    double radius;
  };
  std::vector<Ball> balls_;
};

}  // namespace colossus::simplify
