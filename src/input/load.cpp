#include "input/load.hpp"

#include <limits>

#include "core/error.hpp"

namespace colossus::input {
namespace {

class MeshSink : public BlockSink {
 public:
  explicit MeshSink(LoadedMesh& mesh) : mesh_(mesh), base_(mesh.positions.size()) {}

  void vertices(std::uint64_t first, VertexBlock&& block) override {
    const std::size_t end = base_ + first + block.positions.size();
    if (end > std::numeric_limits<std::uint32_t>::max())
      core::fail(core::Status::kBadData,
                 "the inputs have more than {} vertices together, too many to hold in memory",
                 std::numeric_limits<std::uint32_t>::max());
    if (mesh_.positions.size() < end) mesh_.positions.resize(end);
    std::copy(block.positions.begin(), block.positions.end(),
              mesh_.positions.begin() + static_cast<std::ptrdiff_t>(base_ + first));
    if (block.colors.empty()) return;
    if (mesh_.colors.size() < end) mesh_.colors.resize(end);
    std::copy(block.colors.begin(), block.colors.end(),
              mesh_.colors.begin() + static_cast<std::ptrdiff_t>(base_ + first));
  }

  void triangles(TriangleBlock&& block) override {
    for (auto& t : block.triangles) {
      for (auto& v : t) v += static_cast<std::uint32_t>(base_);
      mesh_.triangles.push_back(t);
    }
  }

 private:
  LoadedMesh& mesh_;
  std::size_t base_;
};

}  // namespace

LoadedMesh load_mesh(std::span<const std::string> inputs, const SourceOptions& options) {
  LoadedMesh mesh;
  bool all_have_colors = true;
  for (const auto& path : expand_inputs(inputs)) {
    const auto source = open_source(path, options);
    all_have_colors &= source->info().has_colors;
    const std::size_t first_triangle = mesh.triangles.size();
    MeshSink sink(mesh);
    bool is_uniform = true;
    for (const Part& part : source->parts()) is_uniform &= source->read(part, sink);
    if (!is_uniform) {
      mesh.triangles.resize(first_triangle);
      for (const Part& part : source->sequential_face_parts()) source->read(part, sink);
    }
  }
  if (!all_have_colors) mesh.colors.clear();
  if (mesh.triangles.empty())
    core::fail(core::Status::kBadData, "{}: the input has {} vertices but no triangles",
               inputs.empty() ? "" : inputs[0], mesh.positions.size());
  return mesh;
}

}  // namespace colossus::input
