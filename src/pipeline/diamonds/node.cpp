#include "pipeline/diamonds/node.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codec/node_codec.hpp"
#include "pipeline/diamonds/diamond_region.hpp"
#include "pipeline/diamonds/part_census.hpp"
#include "pipeline/facts/catalog.hpp"
#include "pipeline/nodes/store_node.hpp"
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

// World bounds of what a reader decodes, in the reader's own arithmetic.
class StoredBounds {
 public:
  void add(const codec::coded::CodedPart& part, const hierarchy::Tetrahedron& tetrahedron) {
    for (const codec::coded::Weights& w : part.positions) {
      const codec::coded::ScaledPosition p = codec::coded::scaled_position(w, tetrahedron);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low_[axis] = std::min(low_[axis], p[axis]);
        high_[axis] = std::max(high_[axis], p[axis]);
      }
    }
  }
  void add(const hierarchy::Point& p, int position_bits) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      low_[k] = std::min(low_[k], std::int64_t{p[axis]} << position_bits);
      high_[k] = std::max(high_[k], std::int64_t{p[axis]} << position_bits);
    }
  }
  std::array<double, 6> world(const geometry::Lattice& lattice, int position_bits) const {
    const double step = lattice.step / static_cast<double>(std::int64_t{1} << position_bits);
    std::array<double, 6> bounds{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds[axis] = lattice.origin[axis] + step * static_cast<double>(low_[axis]);
      bounds[axis + 3] = lattice.origin[axis] + step * static_cast<double>(high_[axis]);
    }
    return bounds;
  }

 private:
  codec::coded::ScaledPosition low_{INT64_MAX, INT64_MAX, INT64_MAX};
  codec::coded::ScaledPosition high_{INT64_MIN, INT64_MIN, INT64_MIN};
};

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

std::uint64_t node_bytes(std::uint64_t triangles) { return 250 * triangles; }

NodeResult build_node(const run::Workspace& workspace, const NodeSettings& settings, const NodeTask& task) {
  const Diamond diamond = Diamond::at(task.center);
  NodeResult result;
  std::vector<PlacedMesh> parts = load_parts(workspace, task);
  double deviation = 0.0;
  if (!task.is_leaf)
    parts = simplify_node(settings, diamond, task.least_error, std::move(parts), result.node.statistics,
                          deviation);

  container::NodeRow& row = result.node.row;
  row.level = static_cast<std::uint32_t>(diamond.level);
  row.center = {task.center.x, task.center.y, task.center.z};
  row.flags = task.is_leaf ? container::kNodeIsLeaf : 0;
  codec::coded::CodedNode mesh;
  mesh.position_bits = settings.quantize.position_bits;
  mesh.has_normals = settings.quantize.normals;
  mesh.has_colors = settings.quantize.colors;
  StoredBounds bounds;
  for (const PlacedMesh& part : parts) {
    const hierarchy::Tetrahedron& tetrahedron = diamond.tetrahedra[part.place];
    codec::quantization::Quantized stored = codec::quantization::quantize(
        part.content.mesh, tetrahedron, static_cast<std::uint8_t>(part.place), settings.quantize);
    const simplify::AngleCounts angles = simplify::count_small_angles(part.content.mesh);
    result.node.statistics.angles.below_5_degrees += angles.below_5_degrees;
    result.node.statistics.angles.below_15_degrees += angles.below_15_degrees;
    result.node.statistics.angles.below_30_degrees += angles.below_30_degrees;
    if (!task.is_leaf) result.node.statistics.reached_triangles += part.content.mesh.triangles.size();
    const PartCensus census = take_census(stored, task.is_leaf);
    result.node.statistics.inconsistent_edges += census.inconsistent_edges;
    if (task.is_leaf) {
      result.node.statistics.finest_border_edges += census.border_edges;
      result.node.statistics.finest_nonmanifold_edges += census.nonmanifold_edges;
      result.node.area += area_of(stored.tetrahedron, tetrahedron, mesh.position_bits);
    }
    const double displacement = stored.displacement * settings.lattice.step;
    result.node.displacement = std::max(result.node.displacement, displacement);
    if (task.is_leaf && part.content.mesh.triangles.size() > settings.leaf_triangles)
      row.flags = static_cast<std::uint8_t>(row.flags | container::kNodeIsAboveLimit);
    row.tetra_mask = static_cast<std::uint8_t>(row.tetra_mask | 1U << part.place);
    row.vertices += static_cast<std::uint32_t>(stored.tetrahedron.positions.size());
    row.triangles += static_cast<std::uint32_t>(stored.tetrahedron.triangles.size());
    bounds.add(stored.tetrahedron, tetrahedron);
    codec::put_in_order(stored.tetrahedron, *settings.codec);
    mesh.parts.push_back(std::move(stored.tetrahedron));
  }
  row.error = std::max(deviation * settings.lattice.step + result.node.displacement + settings.input_error,
                       task.least_error);
  if (row.triangles == 0) bounds.add(task.center, mesh.position_bits);
  row.bounds = bounds.world(settings.lattice, mesh.position_bits);
  const codec::Codec& codec = *settings.codec;
  nodes::store_node(workspace, codec, codec::encode(mesh, codec), result.node);
  if (!task.is_leaf)
    for (const PlacedMesh& part : parts)
      result.tetrahedra.push_back(store_tetrahedron(workspace, {task.center, part.place}, part.content));
  return result;
}

}  // namespace colossus::pipeline::diamonds
