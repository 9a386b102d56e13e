// A mesh on the lattice as it lies in scratch, with points of the input that it is measured by.
#pragma once

#include <vector>

#include "mesh/mesh.hpp"
#include "pipeline/run/workspace.hpp"
#include "scratch/spool.hpp"
#include "simplify/region.hpp"

namespace colossus::pipeline::nodes {

struct SampledMesh {
  mesh::Mesh mesh;
  std::vector<simplify::SurfaceSample> samples;  // of the input; none for leaves, which are the input
};

// About one per triangle of a leaf of the default size.
inline constexpr std::size_t kSamplesPerMesh = 2048;

scratch::RecordRef store(const run::Workspace& workspace, const SampledMesh& content);
SampledMesh load(const run::Workspace& workspace, const scratch::RecordRef& record);

// Leaves are the input: their vertices are its first samples.
void add_missing_samples(SampledMesh& content);

}  // namespace colossus::pipeline::nodes
