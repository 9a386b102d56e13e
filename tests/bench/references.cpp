#include "references.hpp"

#include <meshoptimizer.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <limits>

namespace colossus::bench {
namespace {

struct DoubleTraits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using ReferenceMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

}  // namespace

struct OpenMeshDecimation::State {
  ReferenceMesh mesh;
};

OpenMeshDecimation::OpenMeshDecimation(const mesh::Mesh& mesh) : state_(std::make_unique<State>()) {
  for (const mesh::Vertex& v : mesh.vertices)
    state_->mesh.add_vertex({double(v.position.x), double(v.position.y), double(v.position.z)});
  for (const mesh::Triangle& t : mesh.triangles)
    state_->mesh.add_face(state_->mesh.vertex_handle(t[0]), state_->mesh.vertex_handle(t[1]),
                          state_->mesh.vertex_handle(t[2]));
}

OpenMeshDecimation::~OpenMeshDecimation() = default;

void OpenMeshDecimation::run(std::size_t target_triangles) {
  OpenMesh::Decimater::DecimaterT<ReferenceMesh> decimater(state_->mesh);
  OpenMesh::Decimater::ModQuadricT<ReferenceMesh>::Handle quadrics;
  decimater.add(quadrics);
  decimater.module(quadrics).unset_max_err();
  decimater.initialize();
  decimater.decimate_to_faces(0, target_triangles);
  state_->mesh.garbage_collection();
}

Simplified OpenMeshDecimation::result() const {
  Simplified result;
  for (const auto v : state_->mesh.vertices()) {
    const auto& p = state_->mesh.point(v);
    result.points.push_back({p[0], p[1], p[2]});
  }
  for (const auto f : state_->mesh.faces()) {
    mesh::Triangle triangle{};
    std::size_t corner = 0;
    for (const auto v : state_->mesh.fv_range(f)) triangle[corner++] = static_cast<std::uint32_t>(v.idx());
    result.triangles.push_back(triangle);
  }
  return result;
}

MeshoptSimplification::MeshoptSimplification(const mesh::Mesh& mesh) {
  for (const mesh::Vertex& v : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) positions_.push_back(static_cast<float>(v.position[axis]));
  for (const mesh::Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
}

void MeshoptSimplification::run(std::size_t target_triangles) {
  simplified_.resize(indices_.size());
  const std::size_t count = meshopt_simplify(
      simplified_.data(), indices_.data(), indices_.size(), positions_.data(), positions_.size() / 3,
      3 * sizeof(float), 3 * target_triangles, std::numeric_limits<float>::max(), 0, nullptr);
  simplified_.resize(count);
}

Simplified MeshoptSimplification::result() const {
  Simplified result;
  for (std::size_t i = 0; i < positions_.size(); i += 3)
    result.points.push_back({positions_[i], positions_[i + 1], positions_[i + 2]});
  for (std::size_t i = 0; i < simplified_.size(); i += 3)
    result.triangles.push_back({simplified_[i], simplified_[i + 1], simplified_[i + 2]});
  return result;
}

}  // namespace colossus::bench
