#include "pipeline/diamonds/node.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codec/node_codec.hpp"
#include "pipeline/diamonds/diamond_region.hpp"
#include "pipeline/diamonds/part_census.hpp"
#include "pipeline/facts/catalog.hpp"
#include "pipeline/nodes/node_builder.hpp"
#include "simplify/collapse.hpp"
#include "simplify/deviation.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using hierarchy::Diamond;

std::vector<PlacedMesh> load_parts(const run::Workspace& workspace, const NodeTask& task) {
  std::vector<PlacedMesh> parts;
  for (const NodePart& part : task.parts) parts.push_back({part.place, nodes::load(workspace, part.record)});
  return parts;
}

std::size_t target_of(const NodeSettings& settings, const std::vector<PlacedMesh>& parts) {
  std::uint64_t total = 0;
  std::uint32_t places = 0;
  for (const PlacedMesh& part : parts) {
    total += part.content.mesh.triangles.size();
    places |= 1U << part.place;
  }
  // Above half only to keep the tetrahedra filled, and never so far that a level would stall.
  const std::uint64_t floor = settings.floor_triangles * static_cast<std::uint64_t>(std::popcount(places));
  return std::max(total / 2, std::min(floor, total - total / 5));
}

// Of what is stored whatever simplification adds: the children's error, without what quantisation may take.
double known_error(const NodeSettings& settings, const Diamond& diamond, double least_error) {
  const double unit = std::sqrt(static_cast<double>(squared_distance(diamond.ends[0], diamond.ends[1]))) /
                      static_cast<double>(std::int64_t{1} << settings.quantize.position_bits);
  constexpr double kMostUnits = 3.0;  // by which rounding moves a vertex
  return (least_error - settings.input_error) / settings.lattice.step - kMostUnits * unit;
}

std::vector<PlacedMesh> simplify_node(const NodeSettings& settings, const Diamond& diamond,
                                      double least_error, std::vector<PlacedMesh>&& parts,
                                      facts::NodeStatistics& statistics, double& deviation) {
  const std::size_t target = target_of(settings, parts);
  for (PlacedMesh& part : parts) add_missing_samples(part.content);
  simplify::Region region = make_region(diamond, parts);
  parts.clear();
  region.known_error = known_error(settings, diamond, least_error);
  const simplify::Outcome outcome = simplify::simplify(region, target);
  deviation = outcome.deviation;
  statistics.initial_triangles = outcome.initial_triangles;
  statistics.target_triangles = target;
  statistics.initial_vertices = outcome.initial_vertices;
  statistics.locked_vertices = outcome.locked_vertices;
  parts = split_region(region, diamond);
  for (PlacedMesh& part : parts) simplify::thin_out(part.content.samples, nodes::kSamplesPerMesh);
  return std::move(parts);
}

// The scheme's part of a node: each tetrahedron's mesh quantised, and what that did.
void add_part(nodes::NodeBuilder& builder, const NodeSettings& settings, const NodeTask& task,
              const PlacedMesh& part, const hierarchy::Tetrahedron& tetrahedron,
              codec::coded::CodedNode& mesh) {
  codec::quantization::Quantized stored = codec::quantization::quantize(
      part.content.mesh, tetrahedron, static_cast<std::uint8_t>(part.place), settings.quantize);
  builder.count_angles(part.content.mesh);
  facts::FinishedNode& node = builder.node();
  const PartCensus census = take_census(stored, task.is_leaf);
  node.statistics.inconsistent_edges += census.inconsistent_edges;
  if (task.is_leaf) {
    node.statistics.finest_border_edges += census.border_edges;
    node.statistics.finest_nonmanifold_edges += census.nonmanifold_edges;
    node.area += area_of(stored.tetrahedron, tetrahedron, mesh.position_bits);
    if (part.content.mesh.triangles.size() > settings.leaf_triangles)
      node.row.flags = static_cast<std::uint8_t>(node.row.flags | container::kNodeIsAboveLimit);
  } else {
    node.statistics.reached_triangles += part.content.mesh.triangles.size();
  }
  node.displacement = std::max(node.displacement, stored.displacement * settings.lattice.step);
  for (const codec::coded::Weights& weights : stored.tetrahedron.positions)
    builder.add_position(codec::coded::scaled_position(weights, tetrahedron));
  codec::put_in_order(stored.tetrahedron, *settings.codec);
  mesh.parts.push_back(std::move(stored.tetrahedron));
}

}  // namespace

Bytes NodeTask::to_bytes() const {
  ByteWriter writer;
  writer.put(center);
  writer.put(is_leaf);
  writer.put(least_error);
  writer.put_array<NodePart>(parts);
  return writer.take();
}

NodeTask NodeTask::from_bytes(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  NodeTask task;
  task.center = reader.get<hierarchy::Point>();
  task.is_leaf = reader.get<bool>();
  task.least_error = reader.get<double>();
  task.parts = reader.get_array<NodePart>(reader.remaining() / sizeof(NodePart));
  COLOSSUS_CHECK(!reader.failed());
  return task;
}

Bytes NodeResult::to_bytes() const {
  ByteWriter writer;
  writer.put(node);
  writer.put_array<TetrahedronRecord>(tetrahedra);
  return writer.take();
}

NodeResult NodeResult::from_bytes(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  NodeResult result;
  result.node = reader.get<facts::FinishedNode>();
  result.tetrahedra = reader.get_array<TetrahedronRecord>(reader.remaining() / sizeof(TetrahedronRecord));
  COLOSSUS_CHECK(!reader.failed());
  return result;
}

std::uint64_t task_bytes(std::uint64_t triangles) { return simplify::kBytesPerTriangle * triangles; }

NodeResult build_node(const run::Workspace& workspace, const NodeSettings& settings, const NodeTask& task) {
  const Diamond diamond = Diamond::at(task.center);
  const int bits = settings.quantize.position_bits;
  const nodes::StoredLattice stored{settings.lattice.origin,
                                    settings.lattice.step / static_cast<double>(std::int64_t{1} << bits)};
  const codec::coded::ScaledPosition center{std::int64_t{task.center.x} << bits,
                                            std::int64_t{task.center.y} << bits,
                                            std::int64_t{task.center.z} << bits};
  nodes::NodeBuilder builder(stored, static_cast<std::uint32_t>(diamond.level), task.center, center);
  builder.node().row.flags = task.is_leaf ? container::kNodeIsLeaf : 0;
  std::vector<PlacedMesh> parts = load_parts(workspace, task);
  double deviation = 0.0;
  if (!task.is_leaf)
    parts = simplify_node(settings, diamond, task.least_error, std::move(parts), builder.node().statistics,
                          deviation);
  codec::coded::CodedNode mesh;
  mesh.position_bits = bits;
  mesh.has_normals = settings.quantize.normals;
  mesh.has_colors = settings.quantize.colors;
  for (const PlacedMesh& part : parts)
    add_part(builder, settings, task, part, diamond.tetrahedra[part.place], mesh);
  builder.node().row.error =
      std::max(deviation * settings.lattice.step + builder.node().displacement + settings.input_error,
               task.least_error);
  NodeResult result;
  result.node = std::move(builder).store(workspace, mesh, *settings.codec);
  if (!task.is_leaf)
    for (const PlacedMesh& part : parts)
      result.tetrahedra.push_back(store_tetrahedron(workspace, {task.center, part.place}, part.content));
  return result;
}

}  // namespace colossus::pipeline::diamonds
