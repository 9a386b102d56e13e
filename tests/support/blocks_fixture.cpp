#include "support/blocks_fixture.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "codec/coded/renumber.hpp"
#include "codec/node_codec.hpp"
#include "container/chunk.hpp"
#include "container/writer.hpp"

namespace colossus::support {
namespace {

using geometry::Point;
using hierarchy::CubeId;

// In eighths of the root's side.
constexpr std::array<double, 3> kOrigin{-3.25, 10.5, 0.125};

// The vertices in order of first use, then the others, as they were.
std::vector<std::uint32_t> order_of_use(const codec::coded::CodedPart& mesh) {
  std::vector<std::uint32_t> order;
  std::vector<bool> is_listed(mesh.positions.size());
  const auto add = [&](std::uint32_t v) {
    if (!is_listed[v]) order.push_back(v);
    is_listed[v] = true;
  };
  for (const mesh::Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) add(v);
  for (std::uint32_t v = 0; v < is_listed.size(); ++v) add(v);
  return order;
}

// Reorders the mesh; the parents of its children's vertices are not touched. Returns the new indices.
std::vector<std::uint32_t> put_in_order_of_use(codec::coded::CodedPart& mesh) {
  const std::vector<std::uint32_t> order = order_of_use(mesh);
  std::vector<std::uint32_t> renumbered(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) renumbered[order[i]] = i;
  codec::coded::permute(mesh.positions, order);
  codec::coded::permute(mesh.normals, order);
  codec::coded::permute(mesh.colors, order);
  codec::coded::permute(mesh.parents, order);
  for (mesh::Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) v = renumbered[v];
  return renumbered;
}

}  // namespace

void move_vertex(codec::coded::CodedNode& node, std::size_t vertex, const Point& to) {
  std::vector<Point> positions = lattice_positions(node);
  positions[vertex] = to;
  set_lattice_positions(node, positions);
}

BlocksFixture::BlocksFixture(const WorldMesh& mesh, int deepest, double sigma0, int position_bits,
                             double root_side)
    : deepest_(deepest), root_side_(root_side), sigma0_(sigma0) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  folder_ = std::filesystem::path(::testing::TempDir()) /
            fmt::format("blocks_{}_{}_{}", test->test_suite_name(), test->name(), ::getpid());
  std::filesystem::create_directories(folder_);
  path_ = folder_ / "statue.h5";
  const int root_bits = deepest + position_bits;
  metadata.scheme = hierarchy::kBlocks;
  metadata.lattice = {kOrigin, std::ldexp(root_side, -root_bits), root_bits};
  for (double& origin : metadata.lattice.origin) origin *= root_side / kRootSide;
  metadata.position_bits = position_bits;
  metadata.has_normals = true;
  metadata.has_colors = true;
  metadata.parameters = {{"sigma0", sigma0}, {"block_size", 4}};
  metadata.inputs = {{"generated.ply", 123, std::string(32, '0')}};
  // Clustering pinches: the number of non-manifold edges is not held against the coarser levels.
  metadata.counts = {{"border_edges", 0}, {"nonmanifold_edges", 1}};
  place(mesh);
  build();
  describe();
}

BlocksFixture::~BlocksFixture() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void BlocksFixture::place(const WorldMesh& mesh) {
  geometry::Bounds bounds;
  for (const verify::measure::WorldPoint& p : mesh.points) bounds.add(p);
  double extent = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    extent = std::max(extent, bounds.high[axis] - bounds.low[axis]);
  input = mesh;
  for (verify::measure::WorldPoint& p : input.points) {
    Point q;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double share = 0.02 + 0.96 * (p[axis] - bounds.low[axis]) / extent;
      p[axis] = metadata.lattice.origin[axis] + root_side_ * share;
      q[static_cast<int>(axis)] =
          static_cast<std::int32_t>(std::ldexp(share, metadata.lattice.root_bits) + 0.5);
    }
    points_.push_back(q);
  }
}

// The parent of every vertex of this level in the lists: the first vertex in the same cell.
std::vector<std::uint32_t> BlocksFixture::cluster(const VertexLists& lists, int level) const {
  const auto cell = static_cast<std::int32_t>(std::ldexp(sigma0_, metadata.lattice.root_bits - level - 1));
  std::map<Point, std::uint32_t> first;
  std::vector<std::uint32_t> parents(points_.size());
  for (const auto& [cube, list] : lists)
    for (const std::uint32_t v : list) {
      const Point& p = points_[v];
      const auto [found, is_new] = first.try_emplace({p.x / cell, p.y / cell, p.z / cell}, v);
      parents[v] = found->second;
    }
  return parents;
}

void BlocksFixture::build() {
  const int root_bits = metadata.lattice.root_bits;
  std::vector<IndexedTriangle> triangles;
  for (const mesh::Triangle& t : input.triangles)
    triangles.push_back(
        {t, hierarchy::cube_of_barycenter(points_[t[0]], points_[t[1]], points_[t[2]], deepest_, root_bits)});
  VertexLists finer;
  std::vector<std::uint32_t> parents;  // of the finer level's vertices
  for (int level = deepest_; level >= 0; --level) {
    std::map<CubeId, std::vector<mesh::Triangle>> by_cube;
    for (const IndexedTriangle& t : triangles) by_cube[t.cube].push_back(t.corners);
    for (const auto& [cube, list] : finer) by_cube[cube.parent()];
    VertexLists lists;
    for (const auto& [cube, corners] : by_cube) {
      std::vector<std::uint32_t>& list = lists[cube];
      std::map<std::uint32_t, std::uint32_t> index;
      const auto add = [&](std::uint32_t v) {
        const auto [found, is_new] = index.try_emplace(v, static_cast<std::uint32_t>(list.size()));
        if (is_new) list.push_back(v);
        return found->second;
      };
      std::vector<mesh::Triangle> local;
      for (const mesh::Triangle& t : corners) {
        const std::uint32_t a = add(t[0]);
        const std::uint32_t b = add(t[1]);
        local.push_back({a, b, add(t[2])});
      }
      for (int octant = 0; octant < 8; ++octant)
        if (const auto child = finer.find(cube.child(octant)); child != finer.end())
          for (const std::uint32_t v : child->second)
            nodes[child->first].mesh.parts[0].parents.push_back(add(parents[v]));
      add_cube(cube, list, local);
    }
    finer = std::move(lists);
    if (level == 0) break;
    parents = cluster(finer, level);
    for (IndexedTriangle& t : triangles) {
      for (auto& v : t.corners) v = parents[v];
      t.cube = t.cube.parent();
    }
    std::erase_if(triangles, [](const IndexedTriangle& t) {
      return t.corners[0] == t.corners[1] || t.corners[1] == t.corners[2] || t.corners[2] == t.corners[0];
    });
  }
}

void BlocksFixture::add_cube(const CubeId& cube, const std::vector<std::uint32_t>& list,
                             const std::vector<mesh::Triangle>& triangles) {
  FixtureCube& node = nodes[cube];
  node.mesh.has_normals = node.mesh.has_colors = true;
  node.mesh.has_parents = cube.level > 0;
  codec::coded::CodedPart& part = node.mesh.parts[0];
  part.triangles = triangles;
  std::vector<Point> positions;
  for (const std::uint32_t v : list) {
    positions.push_back(points_[v]);
    part.normals.push_back(geometry::encode_octahedral(
        geometry::to_normal16(points_[v].x - 4000.0, points_[v].y - 4000.0, points_[v].z - 4000.0)));
    part.colors.push_back({static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(v >> 8), 7, 255});
  }
  set_lattice_positions(node.mesh, positions);
  node.row.tetra_mask = 1;
  node.row.flags = cube.level == deepest_ ? container::kNodeIsLeaf : 0;
  node.row.error = static_cast<double>(deepest_ + 1 - cube.level);
}

void BlocksFixture::describe() {
  // The input is not rounded to the lattice.
  long double input_area = 0;
  for (const mesh::Triangle& t : input.triangles) {
    std::array<long double, 3> u{}, v{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      u[axis] = (input.points[t[1]][axis] - input.points[t[0]][axis]) / metadata.lattice.step;
      v[axis] = (input.points[t[2]][axis] - input.points[t[0]][axis]) / metadata.lattice.step;
    }
    const long double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2],
                      z = u[0] * v[1] - u[1] * v[0];
    input_area += std::sqrt(x * x + y * y + z * z) / 2;
  }
  describe_input(metadata, input, static_cast<double>(input_area));
  std::vector<std::uint64_t> inconsistent(static_cast<std::size_t>(deepest_) + 1, 0);
  std::uint64_t triangles = 0, border = 0, nonmanifold = 0;
  long double area = 0;
  EdgeMap finest;
  for (const auto& [cube, node] : nodes) {
    std::vector<ExactPosition> positions;
    for (const Point& p : lattice_positions(node.mesh)) positions.push_back({p.x, p.y, p.z});
    EdgeMap edges;
    add_edges(edges, positions, node.mesh.parts[0].triangles);
    for (const auto& [ends, uses] : edges)
      inconsistent[static_cast<std::size_t>(cube.level)] += uses.is_inconsistent() ? 1 : 0;
    if (cube.level != deepest_) continue;
    add_edges(finest, positions, node.mesh.parts[0].triangles);
    triangles += node.mesh.parts[0].triangles.size();
    area += area_of(positions, node.mesh.parts[0].triangles);
  }
  for (const auto& [ends, uses] : finest) {
    border += uses.uses == 1 ? 1 : 0;
    nonmanifold += uses.uses > 2 ? 1 : 0;
  }
  set_count(metadata, "finest_triangles", triangles);
  set_count(metadata, "finest_border_edges", border);
  set_count(metadata, "finest_nonmanifold_edges", nonmanifold);
  set_measure(metadata, "finest_area", static_cast<double>(area));
  set_inconsistent_edges(metadata, inconsistent);
}

void BlocksFixture::measure_errors() {
  const verify::measure::SurfaceIndex index(input.surface());
  for (auto entry = nodes.rbegin(); entry != nodes.rend(); ++entry) {
    auto& [cube, node] = *entry;
    std::vector<verify::measure::WorldPoint> points;
    for (const Point& p : lattice_positions(node.mesh)) {
      verify::measure::WorldPoint world{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        world[axis] = metadata.lattice.origin[axis] + metadata.lattice.step * p[static_cast<int>(axis)];
      points.push_back(world);
    }
    double error = metadata.lattice.step;
    if (!node.mesh.parts[0].triangles.empty())
      for (const verify::measure::WorldPoint& p :
           verify::measure::sample_surface({points, node.mesh.parts[0].triangles}, 5000, 7))
        error = std::max(error, 1.3 * index.nearest(p).distance);
    for (int octant = 0; octant < 8; ++octant)
      if (const auto child = nodes.find(cube.child(octant)); child != nodes.end())
        error = std::max(error, child->second.row.error);
    node.row.error = error;
  }
}

void BlocksFixture::write() const {
  std::vector<container::NodeRow> rows;
  std::vector<core::Bytes> frames;
  std::map<CubeId, std::vector<std::uint32_t>> renumbered;  // by cube; parents come before their children
  for (const auto& [cube, node] : nodes) {
    codec::coded::CodedNode mesh = node.mesh;
    if (const auto found = renumbered.find(cube.parent()); found != renumbered.end())
      for (std::uint32_t& parent : mesh.parts[0].parents)
        if (parent < found->second.size()) parent = found->second[parent];
    renumbered[cube] = put_in_order_of_use(mesh.parts[0]);
    container::NodeRow row = node.row;
    const Point center = cube.center(metadata.lattice.root_bits);
    row.level = static_cast<std::uint32_t>(cube.level);
    row.center = {center.x, center.y, center.z};
    if (!node.keeps_row) {
      row.vertices = static_cast<std::uint32_t>(node.mesh.parts[0].positions.size());
      row.triangles = static_cast<std::uint32_t>(node.mesh.parts[0].triangles.size());
      geometry::Bounds bounds;
      for (const Point& p : lattice_positions(node.mesh))
        bounds.add({metadata.lattice.origin[0] + metadata.lattice.step * p.x,
                    metadata.lattice.origin[1] + metadata.lattice.step * p.y,
                    metadata.lattice.origin[2] + metadata.lattice.step * p.z});
      row.bounds = {bounds.low[0],  bounds.low[1],  bounds.low[2],
                    bounds.high[0], bounds.high[1], bounds.high[2]};
    }
    container::PackedChunk chunk =
        container::pack_chunk(codec::encode(mesh, codec::codec_named("zstd")).bytes);
    row.capacity_class = chunk.capacity_class;
    row.payload_bytes = chunk.payload_bytes;
    row.stored_bytes = chunk.frame.size();
    row.checksum = chunk.checksum;
    rows.push_back(row);
    frames.push_back(std::move(chunk.frame));
  }
  container::ContainerWriter writer(path_);
  writer.add_nodes(metadata, rows);
  for (const core::Bytes& frame : frames) writer.append_chunk(frame);
  writer.commit();
}

std::unique_ptr<reader::blocks::Statue> BlocksFixture::open() {
  write();
  return std::make_unique<reader::blocks::Statue>(path_);
}

}  // namespace colossus::support
