// quality CONTAINER INPUT: per level, the root-mean-square distances between the uniform cut and the input,
// beside those of OpenMesh's quadric decimation (half-edge collapses) of the whole input to the same number
// of triangles.
#include <fmt/core.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <cstdio>

#include "input/load.hpp"
#include "reader/open.hpp"
#include "verify/measure/distance.hpp"

namespace {

using namespace colossus;

struct DoubleTraits : public OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using ReferenceMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

constexpr std::size_t kSamples = 200'000;

double worse_rms(const verify::measure::SurfaceDistances& d) { return std::max(d.a_to_b.rms, d.b_to_a.rms); }

// The whole input, decimated by OpenMesh from the start: a second call on the same mesh would count deleted
// faces.
double reference_rms(const input::LoadedMesh& input, std::size_t triangles) {
  ReferenceMesh mesh;
  for (const auto& p : input.positions) mesh.add_vertex({p[0], p[1], p[2]});
  for (const auto& t : input.triangles)
    mesh.add_face(mesh.vertex_handle(t[0]), mesh.vertex_handle(t[1]), mesh.vertex_handle(t[2]));
  OpenMesh::Decimater::DecimaterT<ReferenceMesh> decimater(mesh);
  OpenMesh::Decimater::ModQuadricT<ReferenceMesh>::Handle quadrics;
  decimater.add(quadrics);
  decimater.module(quadrics).unset_max_err();
  decimater.initialize();
  decimater.decimate_to_faces(0, triangles);
  mesh.garbage_collection();
  std::vector<verify::measure::WorldPoint> points;
  for (const auto v : mesh.vertices())
    points.push_back({mesh.point(v)[0], mesh.point(v)[1], mesh.point(v)[2]});
  std::vector<mesh::Triangle> kept;
  for (const auto f : mesh.faces()) {
    mesh::Triangle t{};
    std::size_t k = 0;
    for (const auto v : mesh.fv_range(f)) t[k++] = static_cast<std::uint32_t>(v.idx());
    kept.push_back(t);
  }
  return worse_rms(
      verify::measure::surface_distances({points, kept}, {input.positions, input.triangles}, kSamples));
}

void compare(const reader::access::Statue& statue, const std::string& file) {
  const input::LoadedMesh input = input::load_mesh(std::span(&file, 1));
  const verify::measure::Surface surface{input.positions, input.triangles};
  // A level that still contains leaves is finer in parts than it is in others.
  std::uint32_t coarsest_leaf = statue.deepest_level();
  for (reader::access::RowIndex row = 0; row < statue.rows().size(); ++row)
    if (statue.is_leaf(row)) coarsest_leaf = std::min(coarsest_leaf, statue.rows()[row].level);
  fmt::print("level  triangles  rms           OpenMesh rms  ratio\n");
  for (std::uint32_t level = statue.deepest_level(); level + 1 > 0; --level) {
    const reader::access::CutMesh cut = statue.extract(reader::access::AtLevel{level}).mesh;
    const double ours =
        worse_rms(verify::measure::surface_distances({cut.positions, cut.triangles}, surface, kSamples));
    const double theirs =
        cut.triangles.size() < input.triangles.size() ? reference_rms(input, cut.triangles.size()) : 0.0;
    fmt::print("{:5}  {:9}  {:<12.6g}  {:<12.6g}  {}{}\n", level, cut.triangles.size(), ours, theirs,
               theirs > 0.0 ? fmt::format("{:.3f}", ours / theirs) : "-",
               level >= coarsest_leaf ? "  with leaves" : "");
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: quality CONTAINER INPUT\n");
    return 2;
  }
  try {
    compare(*reader::open(argv[1]), argv[2]);
  } catch (const core::Error& error) {
    fmt::print(stderr, "quality: {}\n", error.what());
    return static_cast<int>(error.status());
  }
  return 0;
}
