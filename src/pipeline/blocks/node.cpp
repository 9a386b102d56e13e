#include "pipeline/blocks/node.hpp"

#include <algorithm>
#include <limits>
#include <unordered_set>

#include "codec/coded/lattice_node.hpp"
#include "codec/node_codec.hpp"
#include "geometry/octahedral.hpp"
#include "pipeline/blocks/scheme.hpp"
#include "pipeline/nodes/node_builder.hpp"
#include "simplify/collapse.hpp"
#include "simplify/deviation.hpp"

namespace colossus::pipeline::blocks {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;
using hierarchy::CubeId;

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// A vertex's parent may be half as far as an edge may be long.
std::int64_t reach_of(int level) {
  return static_cast<std::int64_t>(kGreatestSigma / 2.0 *
                                   static_cast<double>(std::int64_t{1} << (geometry::kRootBits - level)));
}

// Numbers vertices in the order in which they come.
class Numbering {
 public:
  explicit Numbering(std::size_t count) : numbers_(count, kNone) {}

  std::uint32_t add(std::uint32_t v) {
    if (numbers_[v] == kNone) {
      numbers_[v] = static_cast<std::uint32_t>(members_.size());
      members_.push_back(v);
    }
    return numbers_[v];
  }
  std::uint32_t operator[](std::uint32_t v) const { return numbers_[v]; }
  std::span<const std::uint32_t> members() const { return members_; }
  void clear() {
    for (const auto v : members_) numbers_[v] = kNone;
    members_.clear();
  }

 private:
  std::vector<std::uint32_t> numbers_;
  std::vector<std::uint32_t> members_;
};

// The cubes of a block as one welded mesh, and the parents that its parts go to.
class Block {
 public:
  Block(const run::Workspace& workspace, const NodeSettings& settings, const NodeTask& task)
      : workspace_(workspace), settings_(settings), task_(task) {
    for (const BlockCube& cube : task.cubes) {
      contents_.push_back(nodes::load(workspace, cube.record.mesh));
      if (cube.record.id.level == settings.grid.levels) add_missing_samples(contents_.back());
      error_ = std::max(error_, cube.error);
      displacement_ = std::max(displacement_, cube.record.displacement);
    }
  }

  NodeResult run() {
    const int level = task_.block.level;
    if (level == 0) return encode_all(std::move(result_));
    weld();
    lock_border();
    find_next_regions();
    simplify(level);
    split();
    return encode_all(std::move(result_));
  }

 private:
  std::size_t parent_index(const CubeId& cube) const {
    const auto found = std::lower_bound(parents_.begin(), parents_.end(), cube.parent());
    return static_cast<std::size_t>(found - parents_.begin());
  }

  void weld() {
    for (const BlockCube& cube : task_.cubes) parents_.push_back(cube.record.id.parent());
    std::sort(parents_.begin(), parents_.end());
    parents_.erase(std::unique(parents_.begin(), parents_.end()), parents_.end());
    std::vector<mesh::Vertex> vertices;
    for (const nodes::SampledMesh& content : contents_)
      vertices.insert(vertices.end(), content.mesh.vertices.begin(), content.mesh.vertices.end());
    const std::vector<std::uint32_t> first = mesh::position_remap(vertices);
    welded_.resize(vertices.size());
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      if (first[v] == v) {
        welded_[v] = static_cast<std::uint32_t>(region_.mesh.vertices.size());
        region_.mesh.vertices.push_back(vertices[v]);
      } else {
        welded_[v] = welded_[first[v]];
      }
    }
    std::uint32_t base = 0;
    for (std::size_t c = 0; c < contents_.size(); ++c) {
      const mesh::Mesh& mesh = contents_[c].mesh;
      const auto cell = static_cast<std::uint16_t>(parent_index(task_.cubes[c].record.id));
      for (const mesh::Triangle& t : mesh.triangles) {
        region_.mesh.triangles.push_back({welded_[base + t[0]], welded_[base + t[1]], welded_[base + t[2]]});
        region_.cells.push_back(cell);
      }
      for (simplify::SurfaceSample sample : contents_[c].samples) {
        sample.anchor = welded_[base + sample.anchor];
        region_.samples.push_back(sample);
      }
      base += static_cast<std::uint32_t>(mesh.vertices.size());
    }
  }

  // What other blocks may use stays where it is.
  void lock_border() {
    constexpr simplify::FaceMask kShared = 1;
    std::unordered_set<Point, geometry::PointHash> shared;
    for (const auto& record : task_.rims)
      for (const Point& p : load_rim(workspace_, record)) shared.insert(p);
    region_.outer_faces = kShared;
    for (const mesh::Vertex& v : region_.mesh.vertices)
      region_.faces.push_back(shared.contains(v.position) ? kShared : 0);
  }

  // The parents' blocks.
  void find_next_regions() {
    std::vector<hierarchy::BlockId> blocks;
    for (const CubeId& parent : parents_) {
      const hierarchy::BlockId block = settings_.block_of(parent);
      const auto found = std::find(blocks.begin(), blocks.end(), block);
      region_.next_regions.push_back(static_cast<std::uint16_t>(found - blocks.begin()));
      if (found == blocks.end()) blocks.push_back(block);
    }
  }

  void simplify(int level) {
    region_.may_place = false;
    region_.reach = reach_of(level);
    region_.color_weight = settings_.has_colors ? settings_.color_weight : 0.0;
    region_.known_error = (error_ - settings_.input_error(displacement_)) / settings_.lattice.step;
    std::vector<Point> before;
    for (const mesh::Vertex& v : region_.mesh.vertices) before.push_back(v.position);
    const std::size_t target = region_.mesh.triangles.size() / 4;
    simplify::Outcome outcome = simplify::simplify(region_, target);
    representative_ = std::move(outcome.representative);
    result_.statistics.initial_triangles = outcome.initial_triangles;
    result_.statistics.target_triangles = target;
    result_.statistics.reached_triangles = outcome.final_triangles;
    result_.statistics.initial_vertices = outcome.initial_vertices;
    result_.statistics.locked_vertices = outcome.locked_vertices;
    error_ =
        std::max(error_, outcome.deviation * settings_.lattice.step + settings_.input_error(displacement_));
    for (std::size_t v = 0; v < before.size(); ++v)
      result_.farthest_parent =
          std::max(result_.farthest_parent,
                   hierarchy::max_distance(before[v], region_.mesh.vertices[representative_[v]].position));
  }

  // What a parent gets: the triangles that its children's have become, and every vertex that theirs have.
  struct Share {
    std::vector<std::uint32_t> triangles;  // of the region
    std::vector<simplify::SurfaceSample> samples;
    std::vector<std::uint32_t> vertices;  // of the children, as the contents' follow each other
  };

  std::vector<Share> find_shares() const {
    std::vector<Share> shares(parents_.size());
    for (std::uint32_t i = 0; i < region_.mesh.triangles.size(); ++i)
      shares[region_.cells[i]].triangles.push_back(i);
    for (const simplify::SurfaceSample& sample : region_.samples)
      shares[sample.cell].samples.push_back(sample);
    std::uint32_t vertex = 0;
    for (std::size_t c = 0; c < contents_.size(); ++c) {
      Share& share = shares[parent_index(task_.cubes[c].record.id)];
      for (std::size_t i = 0; i < contents_[c].mesh.vertices.size(); ++i) share.vertices.push_back(vertex++);
    }
    return shares;
  }

  void split() {
    indices_.resize(welded_.size());
    Numbering numbering(region_.mesh.vertices.size());
    const std::vector<Share> shares = find_shares();
    for (std::size_t p = 0; p < parents_.size(); ++p) {
      const nodes::SampledMesh parent = mesh_of(shares[p], numbering);
      point_to_parents(shares[p], parent.mesh, numbering);
      result_.parents.push_back({store_cube(workspace_, parents_[p], parent, displacement_), error_});
      numbering.clear();
    }
  }

  nodes::SampledMesh mesh_of(const Share& share, Numbering& numbering) const {
    nodes::SampledMesh parent;
    for (const auto i : share.triangles) {
      mesh::Triangle t = region_.mesh.triangles[i];
      for (auto& v : t) v = numbering.add(v);
      parent.mesh.triangles.push_back(t);
    }
    for (const auto v : share.vertices) numbering.add(representative_[welded_[v]]);
    for (const auto v : numbering.members()) parent.mesh.vertices.push_back(region_.mesh.vertices[v]);
    for (simplify::SurfaceSample sample : share.samples) {
      sample.anchor = numbering[sample.anchor];
      sample.cell = 0;
      parent.samples.push_back(sample);
    }
    simplify::thin_out(parent.samples, nodes::kSamplesPerMesh);
    return parent;
  }

  // As the parent's node will store them.
  void point_to_parents(const Share& share, const mesh::Mesh& parent, const Numbering& numbering) {
    std::vector<mesh::Triangle> stored = parent.triangles;
    const std::vector<std::uint32_t> order = order_cube(stored, parent.vertices.size(), *settings_.codec);
    std::vector<std::uint32_t> now(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) now[order[i]] = i;
    for (const auto v : share.vertices) indices_[v] = now[numbering[representative_[welded_[v]]]];
  }

  NodeResult encode_all(NodeResult&& result) {
    std::size_t base = 0;
    for (std::size_t c = 0; c < contents_.size(); ++c) {
      const std::size_t count = contents_[c].mesh.vertices.size();
      const auto parents = task_.block.level == 0
                               ? std::span<const std::uint32_t>()
                               : std::span<const std::uint32_t>(indices_).subspan(base, count);
      result.nodes.push_back(encode_cube(task_.cubes[c], contents_[c].mesh, parents));
      base += count;
    }
    return std::move(result);
  }

  facts::FinishedNode encode_cube(const BlockCube& cube, const mesh::Mesh& mesh,
                                  std::span<const std::uint32_t> parents) {
    const Grid& grid = settings_.grid;
    const auto level = static_cast<std::uint32_t>(cube.record.id.level);
    const Point center = cube.record.id.center(grid.root_bits());
    nodes::NodeBuilder builder({settings_.lattice.origin, settings_.lattice.step * grid.spacing()}, level,
                               center, {center.x, center.y, center.z});
    codec::coded::CodedNode stored = codec::coded::lattice_node();
    codec::coded::CodedPart& part = stored.parts[0];
    stored.has_normals = true;
    stored.has_colors = settings_.has_colors;
    stored.has_parents = level > 0;
    part.triangles = mesh.triangles;
    const std::vector<std::uint32_t> order =
        order_cube(part.triangles, mesh.vertices.size(), *settings_.codec);
    std::vector<Point> positions;
    positions.reserve(order.size());
    for (const auto i : order) {
      const mesh::Vertex& v = mesh.vertices[i];
      Point p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = v.position[axis] / grid.spacing();
      builder.add_position({p.x, p.y, p.z});
      positions.push_back(p);
      part.normals.push_back(geometry::encode_octahedral(v.normal));
      if (settings_.has_colors) part.colors.push_back(v.color);
      if (stored.has_parents) part.parents.push_back(parents[i]);
    }
    set_lattice_positions(stored, positions);
    builder.count_angles(mesh);
    facts::FinishedNode& node = builder.node();
    if (cube.record.id.level == grid.levels) {
      node.row.flags = container::kNodeIsLeaf;
      node.area = nodes::area_of(positions, part.triangles);
    }
    node.row.error = cube.error;
    node.statistics.inconsistent_edges = cube.record.inconsistent_edges;
    node.displacement = settings_.input_error(cube.record.displacement);
    return std::move(builder).store(workspace_, stored, *settings_.codec);
  }

  const run::Workspace& workspace_;
  const NodeSettings& settings_;
  const NodeTask& task_;
  std::vector<nodes::SampledMesh> contents_;  // by cube
  double error_ = 0.0;
  double displacement_ = 0.0;  // see CubeRecord
  std::vector<CubeId> parents_;
  std::vector<std::uint32_t> welded_;  // per vertex of all cubes: the region's
  simplify::Region region_;
  std::vector<std::uint32_t> representative_;  // per vertex of the region before: the one after
  std::vector<std::uint32_t> indices_;         // per vertex of all cubes: within its parent cube
  NodeResult result_;
};

}  // namespace

Bytes NodeTask::to_bytes() const {
  ByteWriter writer;
  writer.put(block);
  writer.put(std::uint64_t{cubes.size()});
  writer.put_array<BlockCube>(cubes);
  writer.put_array<scratch::RecordRef>(rims);
  return writer.take();
}

NodeTask NodeTask::from_bytes(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  NodeTask task;
  task.block = reader.get<hierarchy::BlockId>();
  const auto count = reader.get<std::uint64_t>();
  task.cubes = reader.get_array<BlockCube>(count);
  task.rims = reader.get_array<scratch::RecordRef>(reader.remaining() / sizeof(scratch::RecordRef));
  COLOSSUS_CHECK(!reader.failed());
  return task;
}

Bytes NodeResult::to_bytes() const {
  ByteWriter writer;
  writer.put(std::array<std::uint64_t, 2>{nodes.size(), parents.size()});
  writer.put(statistics);
  writer.put(farthest_parent);
  writer.put_array<facts::FinishedNode>(nodes);
  writer.put_array<BlockCube>(parents);
  return writer.take();
}

NodeResult NodeResult::from_bytes(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  const auto counts = reader.get<std::array<std::uint64_t, 2>>();
  NodeResult result;
  result.statistics = reader.get<facts::NodeStatistics>();
  result.farthest_parent = reader.get<std::int64_t>();
  result.nodes = reader.get_array<facts::FinishedNode>(counts[0]);
  result.parents = reader.get_array<BlockCube>(counts[1]);
  COLOSSUS_CHECK(!reader.failed());
  return result;
}

std::uint64_t bytes_per_triangle(bool weighs_colors) {
  // What the cubes' meshes and the maps between vertices add to what simplify() takes; fitted likewise.
  constexpr std::uint64_t kCubeBytesPerTriangle = 40;
  return kCubeBytesPerTriangle +
         (weighs_colors ? simplify::kBytesPerWeighedTriangle : simplify::kBytesPerTriangle);
}

std::uint64_t task_bytes(const NodeSettings& settings, std::uint64_t triangles) {
  return bytes_per_triangle(settings.has_colors && settings.color_weight > 0.0) * triangles;
}

NodeResult build_block(const run::Workspace& workspace, const NodeSettings& settings, const NodeTask& task) {
  return Block(workspace, settings, task).run();
}

}  // namespace colossus::pipeline::blocks
