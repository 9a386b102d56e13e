// What others do to the same mesh: to a number of triangles, with what they need to keep a node's border left
// away.
#pragma once

#include <memory>
#include <vector>

#include "mesh/mesh.hpp"
#include "verify/measure/distance.hpp"

namespace colossus::bench {

struct Simplified {
  std::vector<verify::measure::WorldPoint> points;
  std::vector<mesh::Triangle> triangles;
};

// OpenMesh's DecimaterT with ModQuadricT, doubles. Built by the constructor, so that run() is the
// simplification alone.
class OpenMeshDecimation {
 public:
  explicit OpenMeshDecimation(const mesh::Mesh& mesh);
  ~OpenMeshDecimation();
  // Once per object. At least `target_triangles` remain.
  void run(std::size_t target_triangles);
  Simplified result() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// meshoptimizer's simplifier, no limit of the error, floats.
class MeshoptSimplification {
 public:
  explicit MeshoptSimplification(const mesh::Mesh& mesh);
  void run(std::size_t target_triangles);
  Simplified result() const;

 private:
  std::vector<float> positions_;
  std::vector<std::uint32_t> indices_;
  std::vector<std::uint32_t> simplified_;
};

}  // namespace colossus::bench
