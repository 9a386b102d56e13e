#include "support/diamonds_fixture.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "codec/node_codec.hpp"
#include "codec/quantization/quantize.hpp"
#include "container/chunk.hpp"
#include "container/writer.hpp"
#include "geometry/plane.hpp"

namespace colossus::support {
namespace {

using geometry::Point;
using hierarchy::Diamond;
using hierarchy::Tetrahedron;
using hierarchy::TetrahedronId;
using mesh::Mesh;
using mesh::Vertex;

Vertex cut_vertex(Vertex a, Vertex b, const geometry::Plane& plane) {
  if (b.position < a.position) std::swap(a, b);
  const std::int64_t side_a = plane.side(a.position);
  const std::int64_t side_b = plane.side(b.position);
  Vertex v = mesh::interpolate(a, b, std::abs(side_a), std::abs(side_a) + std::abs(side_b));
  v.position = geometry::cut_edge(a.position, b.position, side_a, side_b);
  return v;
}

// No bisection thins out the triangles around one vertex.
constexpr int kDeepestLevel = 40;

// The part on the side of `sign`; triangles in the plane belong to the positive one.
Mesh clip(const Mesh& whole, const geometry::Plane& plane, int sign) {
  Mesh part;
  for (const mesh::Triangle& t : whole.triangles) {
    std::vector<Vertex> polygon;
    bool is_beyond = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vertex& v = whole.vertices[t[k]];
      const Vertex& w = whole.vertices[t[(k + 1) % 3]];
      const std::int64_t side = plane.side(v.position) * sign;
      if (side >= 0) polygon.push_back(v);
      is_beyond = is_beyond || side > 0;
      const std::int64_t next = plane.side(w.position) * sign;
      if ((side > 0 && next < 0) || (side < 0 && next > 0)) polygon.push_back(cut_vertex(v, w, plane));
    }
    if (!is_beyond && !(polygon.size() == 3 && sign > 0)) continue;
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      const auto base = static_cast<std::uint32_t>(part.vertices.size());
      part.vertices.insert(part.vertices.end(), {polygon[0], polygon[k - 1], polygon[k]});
      part.triangles.push_back({base, base + 1, base + 2});
    }
  }
  mesh::weld(part);
  return part;
}

using Pieces = std::map<TetrahedronId, Mesh>;

Pieces root_pieces(const Mesh& whole) {
  std::vector<Mesh> pieces{whole};
  for (const auto& plane : hierarchy::root_planes()) {
    std::vector<Mesh> next;
    for (const Mesh& piece : pieces)
      for (const int sign : {1, -1}) next.push_back(clip(piece, plane, sign));
    pieces = std::move(next);
  }
  Pieces roots;
  const Diamond root = Diamond::at(hierarchy::root_center());
  for (std::uint32_t place = 0; place < 6; ++place) roots[{root.center, place}] = {};
  for (const Mesh& piece : pieces)
    for (std::uint32_t place = 0; place < 6 && !piece.vertices.empty(); ++place)
      if (std::all_of(piece.vertices.begin(), piece.vertices.end(),
                      [&](const Vertex& v) { return root.tetrahedra[place].contains(v.position); }))
        roots[{root.center, place}] = piece;
  return roots;
}

// Splits a diamond, its parents first: the halves take the place of its tetrahedra among the leaves.
void split(Pieces& leaves, std::set<Point>& is_split, const Point& center) {
  if (!is_split.insert(center).second) return;
  const Diamond diamond = Diamond::at(center);
  for (const Point& parent : diamond.parents()) split(leaves, is_split, parent);
  for (std::uint32_t place = 0; place < static_cast<std::uint32_t>(diamond.place_count); ++place) {
    if (!diamond.is_inside[place]) continue;
    const Tetrahedron& t = diamond.tetrahedra[place];
    const Mesh whole = leaves.at({center, place});
    leaves.erase({center, place});
    for (int end = 0; end < 2; ++end)
      leaves[hierarchy::id_of(t.child(end))] = clip(whole, t.bisector(), end == 0 ? 1 : -1);
  }
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  const auto base = static_cast<std::uint32_t>(a.vertices.size());
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const mesh::Triangle& t : b.triangles)
    both.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  mesh::weld(both);
  return both;
}

}  // namespace

WorldMesh torus(std::size_t columns, std::size_t rows) {
  WorldMesh mesh;
  for (std::size_t i = 0; i < columns; ++i)
    for (std::size_t j = 0; j < rows; ++j) {
      const double u = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(columns);
      const double v = 2.0 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(rows);
      const double r = 3.0 + (1.0 + 0.1 * std::sin(5.0 * u)) * std::cos(v);
      mesh.points.push_back(
          {r * std::cos(u), 0.8 * r * std::sin(u) + 0.1 * std::sin(v), std::sin(v) + 0.3 * std::cos(u)});
      const auto at = [&](std::size_t a, std::size_t b) {
        return static_cast<std::uint32_t>(a % columns * rows + b % rows);
      };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

WorldMesh sphere(int rounds) {
  WorldMesh mesh;
  mesh.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int round = 0; round < rounds; ++round) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.points.size()));
      if (is_new) {
        verify::measure::WorldPoint p{};
        for (std::size_t k = 0; k < 3; ++k) p[k] = mesh.points[a][k] + mesh.points[b][k];
        const double length = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        for (double& c : p) c /= length;
        mesh.points.push_back(p);
      }
      return found->second;
    };
    std::vector<mesh::Triangle> finer;
    for (const auto& t : mesh.triangles) {
      const std::uint32_t a = middle(t[0], t[1]);
      const std::uint32_t b = middle(t[1], t[2]);
      const std::uint32_t c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

DiamondsFixture::DiamondsFixture(const WorldMesh& mesh, std::size_t leaf_triangles, int position_bits,
                                 const std::optional<geometry::Lattice>& lattice) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  folder_ = std::filesystem::path(::testing::TempDir()) /
            fmt::format("reader_{}_{}_{}", test->test_suite_name(), test->name(), ::getpid());
  std::filesystem::create_directories(folder_);
  path_ = folder_ / "statue.h5";
  geometry::Bounds bounds;
  for (const verify::measure::WorldPoint& p : mesh.points) bounds.add(p);
  lattice_ = lattice ? *lattice : geometry::Lattice::fit(bounds);
  metadata.scheme = hierarchy::kDiamonds;
  metadata.lattice = {lattice_.origin, lattice_.step, geometry::kRootBits};
  metadata.position_bits = position_bits;
  metadata.has_normals = true;
  metadata.has_colors = true;
  metadata.options = {{"leaf-triangles", fmt::format("{}", leaf_triangles)}};
  metadata.inputs = {{"generated.ply", 123, std::string(32, '0')}};
  metadata.counts = {{"triangles", mesh.triangles.size()}, {"border_edges", 0}, {"nonmanifold_edges", 0}};
  build(mesh, leaf_triangles);
  set_errors();
  metadata.levels = {{"target", std::vector<std::uint64_t>(nodes.rbegin()->first.first + 1, 77)},
                     {"locked", std::vector<double>(nodes.rbegin()->first.first + 1, 0.25)}};
  describe(mesh);
}

DiamondsFixture::~DiamondsFixture() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void DiamondsFixture::build(const WorldMesh& world, std::size_t leaf_triangles) {
  Mesh whole;
  for (const verify::measure::WorldPoint& p : world.points) {
    Vertex v;
    v.position = lattice_.input_vertex(p);
    v.normal = geometry::to_normal16(p[0], p[1], p[2]);
    v.color = {static_cast<std::uint8_t>(v.position.x >> 22), static_cast<std::uint8_t>(v.position.y >> 22),
               7, 255};
    whole.vertices.push_back(v);
  }
  whole.triangles = world.triangles;
  mesh::weld(whole);
  Pieces pieces = root_pieces(whole);
  std::set<Point> is_split;
  for (bool is_done = false; !is_done;) {
    const auto large = std::find_if(pieces.begin(), pieces.end(), [&](const auto& piece) {
      return piece.second.triangles.size() > leaf_triangles &&
             hierarchy::level_of(piece.first.center) < kDeepestLevel;
    });
    is_done = large == pieces.end();
    if (!is_done) split(pieces, is_split, Point{large->first.center});
  }
  for (const auto& [id, piece] : pieces) encode(id, piece);
  for (auto& [key, node] : nodes) node.row.flags = container::kNodeIsLeaf;
  // From the finest diamonds up.
  std::vector<Point> order(is_split.begin(), is_split.end());
  std::sort(order.begin(), order.end(),
            [](const Point& a, const Point& b) { return hierarchy::level_of(a) > hierarchy::level_of(b); });
  for (const Point& center : order) {
    const Diamond diamond = Diamond::at(center);
    for (std::uint32_t place = 0; place < static_cast<std::uint32_t>(diamond.place_count); ++place) {
      if (!diamond.is_inside[place]) continue;
      const Tetrahedron& t = diamond.tetrahedra[place];
      const TetrahedronId id{center, place};
      pieces[id] = joined(pieces.at(hierarchy::id_of(t.child(0))), pieces.at(hierarchy::id_of(t.child(1))));
      encode(id, pieces[id]);
    }
    if (const auto found = nodes.find({static_cast<std::uint32_t>(diamond.level), center});
        found != nodes.end())
      found->second.row.flags = 0;
  }
}

void DiamondsFixture::encode(const TetrahedronId& id, const Mesh& mesh) {
  if (mesh.triangles.empty()) return;
  auto quantized =
      codec::quantization::quantize(mesh, hierarchy::tetrahedron_of(id), static_cast<std::uint8_t>(id.place),
                                    {metadata.position_bits, true, true});
  if (quantized.tetrahedron.triangles.empty()) return;
  FixtureNode& node = nodes[{static_cast<std::uint32_t>(hierarchy::level_of(id.center)), id.center}];
  node.mesh.position_bits = metadata.position_bits;
  node.mesh.has_normals = node.mesh.has_colors = true;
  auto& parts = node.mesh.parts;
  parts.insert(
      std::find_if(parts.begin(), parts.end(), [&](const auto& part) { return part.place > id.place; }),
      std::move(quantized.tetrahedron));
  node.row.error = std::max(node.row.error, quantized.displacement * lattice_.step + lattice_.input_error());
}

void DiamondsFixture::set_errors() {
  // From the finest nodes up: never smaller than a child's, a little larger than it must be.
  for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
    const auto& [key, value] = *node;
    for (const Point& parent : Diamond::at(key.second).parents())
      if (const auto found = nodes.find({key.first - 1, parent}); found != nodes.end())
        found->second.row.error = std::max(found->second.row.error, value.row.error);
  }
}

void DiamondsFixture::describe(const WorldMesh& mesh) {
  std::vector<ExactPosition> on_lattice;
  for (const verify::measure::WorldPoint& p : mesh.points) {
    const Point q = lattice_.input_vertex(p);
    on_lattice.push_back({q.x, q.y, q.z});
  }
  describe_input(metadata, mesh, static_cast<double>(area_of(on_lattice, mesh.triangles)));
  std::vector<std::uint64_t> inconsistent(nodes.rbegin()->first.first + 1, 0);
  std::uint64_t triangles = 0, border = 0, nonmanifold = 0;
  long double area = 0;
  for (const auto& [key, node] : nodes)
    for (const auto& part : node.mesh.parts) {
      const Tetrahedron t = Diamond::at(key.second).tetrahedra[part.place];
      std::vector<ExactPosition> positions;
      std::map<ExactPosition, codec::coded::Weights> weights;
      for (const auto& w : part.positions) {
        ExactPosition p{};
        for (std::size_t corner = 0; corner < 4; ++corner)
          for (int axis = 0; axis < 3; ++axis)
            p[static_cast<std::size_t>(axis)] += std::int64_t{w[corner]} * t.corners[corner][axis];
        positions.push_back(p);
        weights[p] = w;
      }
      EdgeMap edges;
      add_edges(edges, positions, part.triangles);
      const bool is_leaf = (node.row.flags & container::kNodeIsLeaf) != 0;
      for (const auto& [ends, uses] : edges) {
        inconsistent[key.first] += uses.is_inconsistent() ? 1 : 0;
        bool is_in_face = false;
        for (std::size_t corner = 0; corner < 4; ++corner)
          is_in_face = is_in_face || weights[ends.first][corner] + weights[ends.second][corner] == 0;
        if (!is_leaf || is_in_face) continue;
        border += uses.uses == 1 ? 1 : 0;
        nonmanifold += uses.uses > 2 ? 1 : 0;
      }
      if (!is_leaf) continue;
      triangles += part.triangles.size();
      area += area_of(positions, part.triangles);
    }
  set_count(metadata, "finest_triangles", triangles);
  set_count(metadata, "finest_border_edges", border);
  set_count(metadata, "finest_nonmanifold_edges", nonmanifold);
  set_measure(metadata, "finest_area", static_cast<double>(std::ldexp(area, -2 * metadata.position_bits)));
  set_inconsistent_edges(metadata, inconsistent);
}

void DiamondsFixture::write() const {
  std::vector<container::NodeRow> rows;
  std::vector<core::Bytes> frames;
  for (const auto& [key, node] : nodes) {
    container::NodeRow row = node.row;
    row.level = key.first;
    row.center = {key.second.x, key.second.y, key.second.z};
    const Diamond diamond = Diamond::at(key.second);
    if (!node.keeps_row) {
      row.tetra_mask = 0;
      row.vertices = row.triangles = 0;
      geometry::Bounds bounds;
      for (const auto& part : node.mesh.parts) {
        row.tetra_mask = static_cast<std::uint8_t>(row.tetra_mask | 1U << part.place);
        row.vertices += static_cast<std::uint32_t>(part.positions.size());
        row.triangles += static_cast<std::uint32_t>(part.triangles.size());
        for (const auto& weights : part.positions) {
          const auto p = codec::coded::scaled_position(weights, diamond.tetrahedra[part.place]);
          const double scale = std::ldexp(1.0, -metadata.position_bits);
          bounds.add(lattice_.world({static_cast<double>(p[0]) * scale, static_cast<double>(p[1]) * scale,
                                     static_cast<double>(p[2]) * scale}));
        }
      }
      row.bounds = {bounds.low[0],  bounds.low[1],  bounds.low[2],
                    bounds.high[0], bounds.high[1], bounds.high[2]};
    }
    core::Bytes payload = codec::encode(node.mesh, codec::codec_named("zstd")).bytes;
    if (change_payload) change_payload(payload);
    container::PackedChunk chunk = container::pack_chunk(payload);
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

std::unique_ptr<reader::diamonds::Statue> DiamondsFixture::open(
    const reader::access::StatueOptions& options) {
  write();
  return std::make_unique<reader::diamonds::Statue>(path_, options);
}

void reorder(codec::coded::CodedPart& part) {
  const codec::coded::CodedPart before = part;
  std::vector<std::uint32_t> renumbered(before.positions.size(), ~std::uint32_t{0});
  part.positions.clear();
  part.normals.clear();
  part.colors.clear();
  for (auto& t : part.triangles)
    for (auto& v : t) {
      if (renumbered[v] == ~std::uint32_t{0}) {
        renumbered[v] = static_cast<std::uint32_t>(part.positions.size());
        part.positions.push_back(before.positions[v]);
        part.normals.push_back(before.normals[v]);
        part.colors.push_back(before.colors[v]);
      }
      v = renumbered[v];
    }
}

void set_count(container::Metadata& metadata, const std::string& name, std::uint64_t value) {
  for (auto& count : metadata.counts)
    if (count.name == name) {
      count.value = value;
      return;
    }
  metadata.counts.push_back({name, value});
}

void set_measure(container::Metadata& metadata, const std::string& name, double value) {
  for (auto& measure : metadata.measures)
    if (measure.name == name) {
      measure.value = value;
      return;
    }
  metadata.measures.push_back({name, value});
}

void set_inconsistent_edges(container::Metadata& metadata, const std::vector<std::uint64_t>& values) {
  std::erase_if(metadata.levels, [](const auto& column) { return column.name == "inconsistent_edges"; });
  metadata.levels.push_back({"inconsistent_edges", values});
}

void describe_input(container::Metadata& metadata, const WorldMesh& mesh, double area) {
  set_count(metadata, "vertices", mesh.points.size());
  set_count(metadata, "triangles", mesh.triangles.size());
  set_measure(metadata, "input_area", area);
  verify::measure::WorldPoint low = mesh.points[mesh.triangles[0][0]];
  verify::measure::WorldPoint high = low;
  for (const auto& t : mesh.triangles)
    for (const auto v : t)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], mesh.points[v][axis]);
        high[axis] = std::max(high[axis], mesh.points[v][axis]);
      }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    set_measure(metadata, std::string("min_") + "xyz"[axis], low[axis]);
    set_measure(metadata, std::string("max_") + "xyz"[axis], high[axis]);
  }
}

void add_edges(EdgeMap& edges, const std::vector<ExactPosition>& positions,
               const std::vector<mesh::Triangle>& triangles) {
  for (const auto& t : triangles) {
    const std::array<ExactPosition, 3> p{positions[t[0]], positions[t[1]], positions[t[2]]};
    if (p[0] == p[1] || p[1] == p[2] || p[2] == p[0]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      EdgeUsesAt& edge = edges[std::minmax(p[k], p[(k + 1) % 3])];
      ++edge.uses;
      if (p[k] < p[(k + 1) % 3]) ++edge.forward;
    }
  }
}

long double area_of(const std::vector<ExactPosition>& positions,
                    const std::vector<mesh::Triangle>& triangles) {
  long double sum = 0;
  for (const auto& t : triangles) {
    std::array<long double, 3> u{}, v{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      u[axis] = static_cast<long double>(positions[t[1]][axis] - positions[t[0]][axis]);
      v[axis] = static_cast<long double>(positions[t[2]][axis] - positions[t[0]][axis]);
    }
    const long double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2],
                      z = u[0] * v[1] - u[1] * v[0];
    sum += std::sqrt(x * x + y * y + z * z) / 2;
  }
  return sum;
}

Census census_of(const reader::access::CutMesh& mesh) {
  Census census;
  std::vector<verify::measure::WorldPoint> points = mesh.positions;
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  census.repeated_points = mesh.positions.size() - points.size();
  std::vector<std::uint32_t> welded;
  for (const verify::measure::WorldPoint& p : mesh.positions)
    welded.push_back(
        static_cast<std::uint32_t>(std::lower_bound(points.begin(), points.end(), p) - points.begin()));
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::minmax(welded[t[k]], welded[t[(k + 1) % 3]]));
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    census.border_edges += end - i == 1 ? 1 : 0;
    census.nonmanifold_edges += end - i > 2 ? 1 : 0;
    i = end;
  }
  return census;
}

}  // namespace colossus::support
