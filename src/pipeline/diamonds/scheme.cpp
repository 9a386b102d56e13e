#include "pipeline/diamonds/scheme.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/log.hpp"
#include "pipeline/buckets/attributes.hpp"
#include "pipeline/diamonds/levels.hpp"
#include "pipeline/diamonds/partition.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/ingest/extent.hpp"
#include "pipeline/run/memory.hpp"

namespace colossus::pipeline::diamonds {
namespace {

// Rounding changes the weights by at most three units in all (one each for three corners that must not become
// 0), so it moves a vertex by at most three times the longest edge over 2^bits.
constexpr double kWeightUnits = 3.0;

double longest_edge(const TetrahedronRecord& leaf) {
  const hierarchy::Diamond diamond = hierarchy::Diamond::at(leaf.id.center);
  return std::sqrt(static_cast<double>(squared_distance(diamond.ends[0], diamond.ends[1])));
}

// The bits that keep every leaf's quantisation, and the lattice's rounding, within the tolerance. Throws
// Error(kUsage) when none do.
int bits_for_tolerance(double tolerance, const Partition& partition, const geometry::Lattice& lattice,
                       double input_error) {
  double longest = 0.0;
  for (const TetrahedronRecord& leaf : partition.leaves) longest = std::max(longest, longest_edge(leaf));
  const auto error_at = [&](int bits) {
    return kWeightUnits * longest * lattice.step / static_cast<double>(1 << bits) + input_error;
  };
  for (int bits = codec::coded::kMinPositionBits; bits <= codec::coded::kMaxPositionBits; ++bits)
    if (error_at(bits) <= tolerance) return bits;
  core::fail(
      core::Status::kUsage,
      "--tolerance {} cannot be kept: the least that can is {}, with {} bits per weight in the largest "
      "leaf; smaller leaves (--leaf-triangles) allow less, but not less than the lattice's {}",
      tolerance, error_at(codec::coded::kMaxPositionBits), codec::coded::kMaxPositionBits, input_error);
}

// How far from each other points may lie that fall together, in the leaves that hold most triangles.
double greatest_gap(const Partition& partition, const geometry::Lattice& lattice, int position_bits) {
  std::vector<std::pair<double, std::uint64_t>> leaves;  // longest edge, triangles
  std::uint64_t whole = 0, sum = 0;
  for (const TetrahedronRecord& leaf : partition.leaves) {
    leaves.emplace_back(longest_edge(leaf), leaf.triangles);
    whole += leaf.triangles;
  }
  std::sort(leaves.begin(), leaves.end());
  double longest = 0.0;
  for (const auto& [edge, triangles] : leaves)
    if (longest = edge; 2 * (sum += triangles) >= whole) break;
  return 2.0 * (lattice.input_error() + longest * lattice.step / static_cast<double>(1 << position_bits));
}

// Bits, and the lattice's error, on rank 0.
void choose_precision(const facts::BuildOptions& options, const facts::Catalog& catalog,
                      const Partition& leaves, NodeSettings& settings) {
  settings.input_error = catalog.lattice.input_error();
  // What stands for a triangle that the lattice, or a cut, took reaches up to two steps beyond it.
  if (leaves.revived > 0) settings.input_error += 2.0 * catalog.lattice.step * geometry::kInputSpacing;
  settings.quantize.position_bits =
      options.tolerance
          ? bits_for_tolerance(*options.tolerance, leaves, catalog.lattice, settings.input_error)
          : options.position_bits;
  ingest::refuse_far_corner(options, catalog,
                            greatest_gap(leaves, catalog.lattice, settings.quantize.position_bits));
}

void log_partition(const cluster::Communicator& ranks, const facts::Catalog& catalog,
                   const Partition& partition) {
  std::uint64_t triangles = 0;
  for (const TetrahedronRecord& leaf : partition.leaves) triangles += leaf.triangles;
  buckets::log_counts(ranks, catalog);
  const std::uint64_t peak = run::greatest_peak_memory(ranks);
  core::log("partition: {} triangles in {} leaf tetrahedra, peak memory {} MB", triangles,
            partition.leaves.size(), peak >> 20);
}

// All triangles of all nodes, per triangle of the input, measured by the number of leaves: a few tetrahedra
// have many coarse nodes above them.
double stored_triangles(double leaves) {
  constexpr double kOfManyLeaves = 2.5;
  static constexpr std::array<std::pair<double, double>, 6> kMeasured{
      {{1, 1.2}, {6, 2.0}, {8, 3.9}, {16, 3.7}, {50, 2.9}, {250, 2.6}}};
  for (std::size_t i = 1; i < kMeasured.size(); ++i) {
    const auto [begin, low] = kMeasured[i - 1];
    const auto [end, high] = kMeasured[i];
    if (leaves < end) return low + (high - low) * std::log(leaves / begin) / std::log(end / begin);
  }
  return kOfManyLeaves;
}

// Of builds of statues of 0.1 to 6 million triangles, see src/README.md.
constexpr double kLeavesPerTask = 6.8;  // triangles of the largest task, in full leaves
// Of scratch, while levels are made.
constexpr double kMeshBytes = 57.0;       // of meshes, per triangle of the input
constexpr double kSampleBytes = 82e3;     // of the samples of all tetrahedra, per leaf
constexpr double kFewNodesBytes = 2.2e6;  // what a hierarchy of few nodes has more, in all,
constexpr double kMostFewNodes = 23.0;    // and at most per triangle of the input
constexpr double kKeptOutput = 0.7;       // the share of the nodes that is made by then

nodes::NodeNeeds estimate(const facts::BuildOptions& options, const facts::Catalog& catalog,
                          const ingest::Occupancy&) {
  const auto triangles = static_cast<double>(catalog.counts.triangles);
  const auto leaf = static_cast<double>(options.leaf_triangles);
  nodes::NodeNeeds needs;
  needs.task_bytes = kLeavesPerTask * static_cast<double>(task_bytes(1)) * std::min(leaf, triangles);
  needs.stored_triangles = stored_triangles(std::max(triangles / leaf, 1.0));
  needs.node_triangles = leaf;
  needs.scratch_bytes =
      kMeshBytes + kSampleBytes / leaf + std::min(kFewNodesBytes / triangles, kMostFewNodes);
  needs.kept_output = kKeptOutput;
  return needs;
}

facts::FinishedNodes build(const run::Workspace& workspace, facts::Catalog& catalog,
                           std::vector<ingest::TriangleGroup>&& groups) {
  const cluster::Communicator& ranks = workspace.ranks;
  const Partition leaves = partition(workspace, catalog, std::move(groups));
  log_partition(ranks, catalog, leaves);
  NodeSettings settings;
  settings.lattice = catalog.lattice;
  ranks.attempt([&] {
    if (ranks.is_root()) choose_precision(workspace.options, catalog, leaves, settings);
  });
  broadcast_value(ranks, settings.quantize.position_bits);
  broadcast_value(ranks, settings.input_error);
  settings.quantize.normals = true;
  settings.codec = &codec::codec_named(workspace.options.codec);
  settings.quantize.colors = catalog.has_colors;
  settings.leaf_triangles = workspace.options.leaf_triangles;
  settings.floor_triangles = floor_triangles(workspace.options);
  return build_levels(workspace, settings, leaves, catalog);
}

}  // namespace

constinit const nodes::Scheme kScheme{hierarchy::kDiamonds,
                                      "cut triangles, the smallest error, cuts of any shape",
                                      "per leaf tetrahedron",
                                      "per barycentric weight",
                                      {},
                                      nullptr,
                                      &estimate,
                                      &build};

}  // namespace colossus::pipeline::diamonds
