// How a sketch is built: beside the phases that serve every scheme, two levels with tasks of their own.
#include <algorithm>
#include <array>
#include <map>

#include "codec/coded/lattice_node.hpp"
#include "codec/node_codec.hpp"
#include "geometry/octahedral.hpp"
#include "hierarchy/octree.hpp"
#include "mesh/topology.hpp"
#include "pipeline/buckets/attributes.hpp"
#include "pipeline/nodes/level_driver.hpp"
#include "pipeline/nodes/node_builder.hpp"
#include "pipeline/nodes/sampled_mesh.hpp"
#include "pipeline/nodes/scheme.hpp"
#include "pipeline/run/phase.hpp"
#include "simplify/collapse.hpp"
#include "toy/sketch.hpp"
#include "toy/tables.hpp"

namespace colossus::toy {
namespace {

using namespace pipeline;
using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;
using hierarchy::CubeId;

// Shared with blocks, which have another meaning for it.
constexpr facts::TypedOption<std::int64_t> kLevels{"levels", "the level of the finest cubes, 0 to 4",
                                                   "Level of the finest cubes"};
constexpr facts::TypedOption<double> kShare{"share", "what the sketch has of the triangles",
                                            "Share of the triangles that the sketch was to have", 0.5};
constexpr facts::TypedOption<bool> kWhole{"whole", "the sketch has all triangles",
                                          "true: the sketch was to have all triangles", false};
constexpr std::array<facts::SchemeOption, 3> kOptions{kLevels, kShare, kWhole};

int cube_level(const run::Workspace& workspace) {
  return static_cast<int>(value_of(kLevels, workspace.options.of_scheme).value_or(kCubeLevel));
}

// What a task comes to: its nodes, and of a bucket also what the sketch is made of.
struct Result {
  std::vector<facts::FinishedNode> nodes;
  std::vector<scratch::RecordRef> meshes;
  buckets::EdgeCensus finest;

  Bytes to_bytes() const {
    ByteWriter writer;
    writer.put(finest);
    writer.put(std::uint64_t{nodes.size()});
    writer.put_array<facts::FinishedNode>(nodes);
    writer.put_array<scratch::RecordRef>(meshes);
    return writer.take();
  }
  static Result from_bytes(std::span<const std::byte> bytes) {
    ByteReader reader(bytes);
    Result result;
    result.finest = reader.get<buckets::EdgeCensus>();
    result.nodes = reader.get_array<facts::FinishedNode>(reader.get<std::uint64_t>());
    result.meshes = reader.get_array<scratch::RecordRef>(reader.remaining() / sizeof(scratch::RecordRef));
    COLOSSUS_CHECK(!reader.failed());
    return result;
  }
};

// The node of a cube, or of the root cube. It takes the triangles in the order of the codec.
facts::FinishedNode store_node(const run::Workspace& workspace, const facts::Catalog& catalog,
                               const CubeId& cube, std::uint32_t level, const mesh::Mesh& mesh,
                               double error) {
  const codec::Codec& codec = codec::codec_named(workspace.options.codec);
  const Point center = cube.center(geometry::kRootBits);
  nodes::NodeBuilder builder({catalog.lattice.origin, catalog.lattice.step}, level, center,
                             {center.x, center.y, center.z});
  codec::coded::CodedNode stored = codec::coded::lattice_node();
  codec::coded::CodedPart& part = stored.parts[0];
  stored.has_normals = true;
  stored.has_colors = catalog.has_colors;
  part.triangles = mesh.triangles;
  std::vector<Point> positions;
  for (const mesh::Vertex& v : mesh.vertices) {
    builder.add_position({v.position.x, v.position.y, v.position.z});
    positions.push_back(v.position);
    part.normals.push_back(geometry::encode_octahedral(v.normal));
    if (catalog.has_colors) part.colors.push_back(v.color);
  }
  set_lattice_positions(stored, positions);
  put_in_order(part, codec);
  builder.count_angles(mesh);
  facts::FinishedNode& node = builder.node();
  for (const mesh::Edge& edge : mesh::edges(mesh.triangles))
    node.statistics.inconsistent_edges += edge.count() == 2 && edge.forward != edge.backward ? 1 : 0;
  node.row.error = error;
  if (level == kFinestLevel) {
    node.row.flags = container::kNodeIsLeaf;
    node.area = nodes::area_of(positions, mesh.triangles);
  }
  return std::move(builder).store(workspace, stored, codec);
}

// The triangles whose barycentres lie in the bucket, by the cube that these lie in, with their vertices.
std::map<CubeId, mesh::Mesh> by_cube(const buckets::LoadedBucket& bucket, int level) {
  std::map<CubeId, mesh::Mesh> cubes;
  for (const mesh::Triangle& t : bucket.mesh.triangles) {
    const auto& vertices = bucket.mesh.vertices;
    const CubeId id = hierarchy::cube_of_barycenter(vertices[t[0]].position, vertices[t[1]].position,
                                                    vertices[t[2]].position, level, geometry::kRootBits);
    if (id.ancestor(bucket.cube.level) != bucket.cube) continue;
    mesh::Mesh& cube = cubes[id];
    if (cube.vertices.empty()) cube.vertices = vertices;  // the unused go when it is welded
    cube.triangles.push_back(t);
  }
  for (auto& [id, cube] : cubes) mesh::weld(cube);
  return cubes;
}

Result make_leaves(const run::Workspace& workspace, const facts::Catalog& catalog,
                   const buckets::LoadedBucket& bucket) {
  if (!bucket.lost.empty())
    core::fail(core::Status::kBadData, "{}: {} triangles collapse on the lattice, which {} cannot keep",
               catalog.input_name(), bucket.lost.size(), kSketch);
  Result result;
  result.finest = bucket.finest;
  for (const auto& [id, cube] : by_cube(bucket, cube_level(workspace))) {
    result.nodes.push_back(
        store_node(workspace, catalog, id, kFinestLevel, cube, catalog.lattice.input_error()));
    result.meshes.push_back(nodes::store(workspace, {cube, {}}));
  }
  return result;
}

Result make_sketch(const run::Workspace& workspace, const facts::Catalog& catalog,
                   std::span<const scratch::RecordRef> leaves) {
  nodes::SampledMesh whole;
  for (const scratch::RecordRef& record : leaves) {
    const mesh::Mesh leaf = nodes::load(workspace, record).mesh;
    const auto base = static_cast<std::uint32_t>(whole.mesh.vertices.size());
    whole.mesh.vertices.insert(whole.mesh.vertices.end(), leaf.vertices.begin(), leaf.vertices.end());
    for (const mesh::Triangle& t : leaf.triangles)
      whole.mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
  mesh::weld(whole.mesh);
  add_missing_samples(whole);
  simplify::Region region;
  region.faces.resize(whole.mesh.vertices.size());
  region.cells.resize(whole.mesh.triangles.size());
  region.may_place = false;
  region.samples = std::move(whole.samples);
  region.mesh = std::move(whole.mesh);
  const facts::SchemeValues& values = workspace.options.of_scheme;
  const double share = *value_of(kWhole, values) ? 1.0 : *value_of(kShare, values);
  const auto target = static_cast<std::uint64_t>(share * static_cast<double>(region.mesh.triangles.size()));
  const simplify::Outcome outcome = simplify::simplify(region, target);
  mesh::weld(region.mesh);
  const double error = outcome.deviation * catalog.lattice.step + catalog.lattice.input_error();
  facts::FinishedNode node = store_node(workspace, catalog, {}, 0, region.mesh, error);
  node.statistics.initial_triangles = outcome.initial_triangles;
  node.statistics.target_triangles = target;
  node.statistics.reached_triangles = outcome.final_triangles;
  node.statistics.initial_vertices = outcome.initial_vertices;
  node.statistics.locked_vertices = outcome.locked_vertices;
  return {{node}, {}, {}};
}

std::uint64_t task_bytes(std::uint64_t triangles) { return 400 * triangles; }

facts::FinishedNodes build(const run::Workspace& workspace, facts::Catalog& catalog,
                           std::vector<ingest::TriangleGroup>&& groups) {
  const int level = cube_level(workspace);
  const std::vector<buckets::BucketRecord> buckets =
      buckets::make_buckets(workspace, catalog, std::move(groups), {}, {level});
  nodes::LevelDriver driver(workspace);
  driver.finished().lattice = {catalog.lattice.origin, catalog.lattice.step, geometry::kRootBits};
  driver.finished().position_bits = workspace.options.position_bits;

  std::map<CubeId, scratch::RecordRef> leaves;  // on rank 0, in an order that no rank has a part in
  nodes::Level finest;
  finest.name = "level 1";
  finest.task_name = "a bucket";
  finest.task_bytes = task_bytes;
  for (std::size_t i = 0; i < buckets.size(); ++i) finest.tasks.push_back({i, buckets[i].triangle_count});
  finest.make = [&](std::size_t i) { return bucket_task(buckets[i]); };
  finest.work = [&](std::span<const std::byte> task) {
    return make_leaves(workspace, catalog, buckets::load_bucket(workspace, task)).to_bytes();
  };
  finest.take = [&](std::span<const std::byte> bytes) {
    Result result = Result::from_bytes(bytes);
    catalog.counts.finest_border_edges += result.finest.border;
    catalog.counts.finest_nonmanifold_edges += result.finest.nonmanifold;
    for (std::size_t i = 0; i < result.nodes.size(); ++i) {
      const auto& center = result.nodes[i].row.center;
      leaves[hierarchy::cube_at({center[0], center[1], center[2]}, level, geometry::kRootBits)] =
          result.meshes[i];
    }
    return std::move(result.nodes);
  };
  driver.run(std::move(finest));
  driver.finish_finest(catalog);
  broadcast_value(workspace.ranks, catalog.counts);

  nodes::Level root;
  root.name = "level 0";
  root.task_name = "the sketch";
  root.task_bytes = task_bytes;
  root.simplified = 0;
  root.tasks = {{0, catalog.counts.triangles}};
  root.make = [&](std::size_t) {
    ByteWriter writer;
    for (const auto& [id, record] : leaves) writer.put(record);
    return writer.take();
  };
  root.work = [&](std::span<const std::byte> task) {
    const auto records =
        ByteReader(task).get_array<scratch::RecordRef>(task.size() / sizeof(scratch::RecordRef));
    return make_sketch(workspace, catalog, records).to_bytes();
  };
  root.take = [](std::span<const std::byte> bytes) { return Result::from_bytes(bytes).nodes; };
  driver.run(std::move(root));
  facts::FinishedNodes finished = driver.take();
  facts::SchemeValues chosen = workspace.options.of_scheme;
  chosen[kLevels.name] = std::int64_t{level};
  finished.options = stored_values(kOptions, chosen);
  finished.option_meanings = facts::meanings_of(kOptions);
  return finished;
}

void check(const facts::BuildOptions& options) {
  const std::int64_t level = value_of(kLevels, options.of_scheme).value_or(kCubeLevel);
  if (level < 0 || level > 4)
    core::fail(core::Status::kUsage, "--levels {} is out of range; choose 0 to 4", level);
}

nodes::NodeNeeds estimate(const facts::BuildOptions&, const facts::Catalog& catalog,
                          const ingest::Occupancy&) {
  const auto triangles = static_cast<double>(catalog.counts.triangles);
  nodes::NodeNeeds needs;
  needs.task_bytes = static_cast<double>(task_bytes(catalog.counts.triangles));
  needs.stored_triangles = 1.5;
  needs.more_bytes = 4.0;  // positions of 30 bits
  needs.node_triangles = triangles;
  needs.scratch_bytes = 48.0;
  return needs;
}

}  // namespace

constinit const nodes::Scheme kSketchScheme{
    kSketch, "the input, and a sketch of it", "of nothing", "of nothing", kOptions, &check, &estimate,
    &build};

}  // namespace colossus::toy
