#include "pipeline/buckets/attributes.hpp"

#include <algorithm>
#include <cmath>

#include "core/log.hpp"
#include "pipeline/ingest/extent.hpp"
#include "pipeline/nodes/sampled_mesh.hpp"
#include "pipeline/run/memory.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::buckets {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;

struct ForNeighbor {
  std::uint32_t bucket = 0;
  std::uint32_t padding = 0;
  scratch::RecordRef record;  // mesh::Vertex
};

// What the attributes phase tells rank 0 about a bucket.
struct BucketResult {
  BucketCounts counts;
  scratch::RecordRef mesh;
  std::uint64_t lost_count = 0;
  scratch::RecordRef lost;
  std::vector<ForNeighbor> lists;

  Bytes to_bytes() const {
    ByteWriter writer;
    writer.put(counts);
    writer.put(mesh);
    writer.put(lost_count);
    writer.put(lost);
    writer.put_array<ForNeighbor>(lists);
    return writer.take();
  }
  static BucketResult from_bytes(std::span<const std::byte> bytes) {
    ByteReader reader(bytes);
    BucketResult result;
    result.counts = reader.get<BucketCounts>();
    result.mesh = reader.get<scratch::RecordRef>();
    result.lost_count = reader.get<std::uint64_t>();
    result.lost = reader.get<scratch::RecordRef>();
    result.lists = reader.get_array<ForNeighbor>(reader.remaining() / sizeof(ForNeighbor));
    COLOSSUS_CHECK(!reader.failed());
    return result;
  }
};

// A triangle goes to all buckets that its bounding box meets: these need its corners, even if it is lost.
std::vector<ForNeighbor> tell_neighbors(const run::Workspace& workspace, const BucketTree& tree,
                                        const CubeId& cube, const mesh::Mesh& mesh,
                                        std::span<const LostTriangle> lost) {
  struct Need {
    std::uint32_t bucket;
    std::uint32_t vertex;  // of the mesh, behind these corners of the lost
    auto operator<=>(const Need&) const = default;
  };
  std::vector<Need> needs;
  std::vector<std::uint32_t> met;
  const auto vertex = [&](std::uint32_t v) -> const mesh::Vertex& {
    if (v < mesh.vertices.size()) return mesh.vertices[v];
    const std::size_t corner = v - mesh.vertices.size();
    return lost[corner / 3].corners[corner % 3];
  };
  const auto look_at = [&](const mesh::Triangle& t) {
    Point low = vertex(t[0]).position, high = low;
    for (const auto v : t)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], vertex(v).position[axis]);
        high[axis] = std::max(high[axis], vertex(v).position[axis]);
      }
    if (cube.contains(low, geometry::kRootBits) && cube.contains(high, geometry::kRootBits)) return;
    tree.find(low, high, met);
    for (const auto v : t)
      if (cube.contains(vertex(v).position, geometry::kRootBits))
        for (const auto bucket : met)
          if (tree.cubes()[bucket] != cube) needs.push_back({bucket, v});
  };
  for (const mesh::Triangle& t : mesh.triangles) look_at(t);
  for (std::size_t i = 0; i < lost.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size() + 3 * i);
    look_at({first, first + 1, first + 2});
  }
  std::sort(needs.begin(), needs.end());
  needs.erase(std::unique(needs.begin(), needs.end()), needs.end());
  std::vector<ForNeighbor> lists;
  std::vector<mesh::Vertex> vertices;
  for (std::size_t i = 0; i < needs.size();) {
    const std::uint32_t bucket = needs[i].bucket;
    vertices.clear();
    for (; i < needs.size() && needs[i].bucket == bucket; ++i) vertices.push_back(vertex(needs[i].vertex));
    lists.push_back({bucket, 0,
                     workspace.writer.append(static_cast<std::uint32_t>(facts::RecordKind::kAttributes),
                                             core::as_bytes(vertices))});
  }
  return lists;
}

std::vector<std::size_t> filled_buckets(const std::vector<Bucket>& buckets) {
  std::vector<std::size_t> filled;
  for (std::size_t i = 0; i < buckets.size(); ++i)
    if (buckets[i].triangle_count > 0) filled.push_back(i);
  std::stable_sort(filled.begin(), filled.end(), [&](std::size_t a, std::size_t b) {
    return buckets[a].triangle_count > buckets[b].triangle_count;
  });
  return filled;
}

std::string crowd_text(const facts::Catalog& catalog, const Bucket& bucket) {
  const double side = static_cast<double>(geometry::kRootSide >> bucket.cube.level);
  const auto low = catalog.lattice.world({side * bucket.cube.x, side * bucket.cube.y, side * bucket.cube.z});
  return fmt::format("a cube of side {} at {} {} {}, in which {} triangles crowd,",
                     side * catalog.lattice.step, low[0], low[1], low[2], bucket.triangle_count);
}

Bytes mesh_task(const Bucket& bucket) {
  ByteWriter writer;
  writer.put(bucket.cube);
  writer.put_array<scratch::RecordRef>(bucket.pieces);
  return writer.take();
}

// In the order of the buckets: a sum of doubles depends on it.
void take_counts(facts::Catalog& catalog, const std::vector<BucketCounts>& of_buckets) {
  facts::InputCounts& counts = catalog.counts;
  std::uint64_t triangles = 0;
  std::array<bool, 4> is_on_diagonal{true, true, true, true};
  for (const BucketCounts& own : of_buckets) {
    counts.merged_vertices += own.merged_vertices;
    counts.attribute_seams += own.attribute_seams;
    counts.color_seams += own.color_seams;
    counts.duplicate += own.duplicates;
    counts.opposite += own.opposites;
    counts.collinear += own.collinear;
    counts.border_edges += own.input.border;
    counts.nonmanifold_edges += own.input.nonmanifold;
    counts.inconsistent_edges += own.input.inconsistent;
    catalog.area += own.area;
    triangles += own.triangles;
    for (std::size_t k = 0; k < 4; ++k) is_on_diagonal[k] = is_on_diagonal[k] && own.is_off_diagonal[k] == 0;
  }
  const bool is_line = std::find(is_on_diagonal.begin(), is_on_diagonal.end(), true) != is_on_diagonal.end();
  if (triangles == counts.collinear || is_line)
    core::fail(
        core::Status::kBadData,
        "{}: no triangle with an area is left: of {} triangles {} are degenerate, {} are so small that they "
        "collapse on the lattice, and the corners of the others are collinear{}: nothing can be built{}",
        catalog.input_name(), counts.triangles, counts.degenerate, counts.collapsed,
        is_line && triangles > 0 ? ", all on one line" : "", ingest::far_corner_text(catalog));
}

BucketResult make_bucket(const run::Workspace& workspace, const facts::Catalog& catalog,
                         const BucketTree& tree, const Rounding& rounding, std::span<const std::byte> task) {
  ByteReader reader(task);
  const auto cube = reader.get<CubeId>();
  ingest::Piece piece;
  while (reader.remaining() > 0) load_piece(workspace, catalog, reader.get<scratch::RecordRef>(), piece);
  const InputBox box{catalog.lattice.input_vertex(catalog.bounds.low),
                     catalog.lattice.input_vertex(catalog.bounds.high)};
  BucketMesh bucket(rounding, cube, box, std::move(piece));
  BucketResult result;
  result.counts = bucket.counts();
  result.lists = tell_neighbors(workspace, tree, cube, bucket.mesh(), bucket.lost());
  result.lost_count = bucket.lost().size();
  if (!bucket.lost().empty())
    result.lost = workspace.writer.append(static_cast<std::uint32_t>(facts::RecordKind::kLost),
                                          core::as_bytes(bucket.lost()));
  result.mesh = nodes::store(workspace, {std::move(bucket.mesh()), {}});
  return result;
}

}  // namespace

std::vector<BucketRecord> give_attributes(const run::Workspace& workspace, facts::Catalog& catalog,
                                          Buckets&& buckets, const Rounding& rounding) {
  const std::vector<std::size_t> filled = filled_buckets(buckets.buckets);
  std::vector<BucketRecord> records(filled.size());
  std::vector<std::vector<ForNeighbor>> lists(filled.size());
  std::vector<BucketCounts> counts(filled.size());
  run_phase(
      workspace, "attributes", filled.size(),
      [&](std::size_t i) {
        const Bucket& bucket = buckets.buckets[filled[i]];
        require_memory(workspace, bucket_mesh_bytes(bucket.triangle_count, bucket.vertex_count),
                       crowd_text(catalog, bucket));
        return mesh_task(bucket);
      },
      [&](std::span<const std::byte> task) {
        return make_bucket(workspace, catalog, buckets.tree, rounding, task).to_bytes();
      },
      [&](std::size_t i, const Bytes& bytes) {
        const BucketResult result = BucketResult::from_bytes(bytes);
        records[i].cube = buckets.buckets[filled[i]].cube;
        records[i].triangle_count = buckets.buckets[filled[i]].triangle_count;
        records[i].finest = result.counts.finest;
        records[i].mesh = result.mesh;
        records[i].lost_count = result.lost_count;
        records[i].lost = result.lost;
        lists[i] = result.lists;
        counts[i] = result.counts;
      });
  workspace.ranks.attempt([&] {
    if (workspace.ranks.is_root()) take_counts(catalog, counts);
  });
  broadcast_value(workspace.ranks, catalog.counts);
  broadcast_value(workspace.ranks, catalog.area);
  // In the order of the buckets, not of arrival: tasks are made of this.
  std::vector<std::size_t> record_of(buckets.buckets.size());
  for (std::size_t i = 0; i < filled.size(); ++i) record_of[filled[i]] = i;
  for (const auto& of_bucket : lists)
    for (const ForNeighbor& list : of_bucket)
      records[record_of[list.bucket]].from_neighbors.push_back(list.record);
  return records;
}

std::vector<BucketRecord> make_buckets(const run::Workspace& workspace, facts::Catalog& catalog,
                                       std::vector<ingest::TriangleGroup>&& groups, const Rounding& rounding,
                                       const BucketOptions& options) {
  Buckets filled = fill_buckets(workspace, catalog, groups, rounding, options);
  groups = {};
  release_phases_up_to(workspace, last_phase(workspace) - 1);
  std::vector<BucketRecord> buckets = give_attributes(workspace, catalog, std::move(filled), rounding);
  release_phases_up_to(workspace, last_phase(workspace) - 1);
  return buckets;
}

void log_counts(const cluster::Communicator& ranks, const facts::Catalog& catalog) {
  const facts::InputCounts& c = catalog.counts;
  core::log(
      "partition: {} degenerate, {} duplicate and {} opposite triangles dropped, {} collapsed; {} collinear "
      "ones stay; {} border, {} non-manifold and {} inconsistently oriented edges",
      c.degenerate, c.duplicate, c.opposite, c.collapsed, c.collinear, c.border_edges, c.nonmanifold_edges,
      c.inconsistent_edges);
  if (ranks.is_root() && catalog.has_face_colors && c.color_seams > 0)
    core::warn("{}: {} vertices lie between faces of different colours, which are averaged",
               catalog.input_name(), c.color_seams);
}

Bytes bucket_task(const BucketRecord& bucket) {
  ByteWriter writer;
  writer.put(bucket.cube);
  writer.put(bucket.finest);
  writer.put(bucket.mesh);
  writer.put(bucket.lost_count);
  writer.put(bucket.lost);
  writer.put_array<scratch::RecordRef>(bucket.from_neighbors);
  return writer.take();
}

LoadedBucket load_bucket(const run::Workspace& workspace, std::span<const std::byte> task) {
  ByteReader reader(task);
  LoadedBucket bucket;
  bucket.cube = reader.get<CubeId>();
  bucket.finest = reader.get<EdgeCensus>();
  bucket.mesh = nodes::load(workspace, reader.get<scratch::RecordRef>()).mesh;
  const auto lost_count = reader.get<std::uint64_t>();
  const auto lost = reader.get<scratch::RecordRef>();
  if (lost_count > 0) {
    const Bytes bytes = workspace.reader.read(lost);
    bucket.lost = ByteReader(bytes).get_array<LostTriangle>(lost_count);
  }
  std::vector<mesh::Vertex> known;
  while (reader.remaining() > 0) {
    const Bytes bytes = workspace.reader.read(reader.get<scratch::RecordRef>());
    const auto list = ByteReader(bytes).get_array<mesh::Vertex>(bytes.size() / sizeof(mesh::Vertex));
    known.insert(known.end(), list.begin(), list.end());
  }
  const auto is_less = [](const mesh::Vertex& a, const mesh::Vertex& b) { return a.position < b.position; };
  std::sort(known.begin(), known.end(), is_less);
  const auto finish = [&](mesh::Vertex& v) {
    if (bucket.cube.contains(v.position, geometry::kRootBits)) return;
    const auto found = std::lower_bound(known.begin(), known.end(), v, is_less);
    COLOSSUS_CHECK(found != known.end() && found->position == v.position, "no attributes for {} {} {}",
                   v.position.x, v.position.y, v.position.z);
    v = *found;
  };
  // Vertices whose triangles are lost are nobody's.
  std::vector<bool> is_finished(bucket.mesh.vertices.size(), false);
  for (const mesh::Triangle& t : bucket.mesh.triangles)
    for (const auto i : t) {
      if (is_finished[i]) continue;
      is_finished[i] = true;
      finish(bucket.mesh.vertices[i]);
    }
  for (LostTriangle& triangle : bucket.lost)
    for (mesh::Vertex& v : triangle.corners) finish(v);
  return bucket;
}

}  // namespace colossus::pipeline::buckets
