#include "build/attributes.hpp"

#include <algorithm>

#include "build/memory.hpp"
#include "build/phase.hpp"
#include "build/sampled_mesh.hpp"

namespace colossus::build {
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
  std::vector<ForNeighbor> lists;

  Bytes to_bytes() const {
    ByteWriter writer;
    writer.put(counts);
    writer.put(mesh);
    writer.put_array<ForNeighbor>(lists);
    return writer.take();
  }
  static BucketResult from_bytes(std::span<const std::byte> bytes) {
    ByteReader reader(bytes);
    BucketResult result;
    result.counts = reader.get<BucketCounts>();
    result.mesh = reader.get<scratch::RecordRef>();
    result.lists = reader.get_array<ForNeighbor>(reader.remaining() / sizeof(ForNeighbor));
    COLOSSUS_CHECK(!reader.failed());
    return result;
  }
};

// A triangle goes to all buckets that its bounding box meets: these need its corners.
std::vector<ForNeighbor> tell_neighbors(const Workspace& workspace, const BucketTree& tree, const Cube& cube,
                                        const mesh::Mesh& mesh) {
  struct Need {
    std::uint32_t bucket;
    std::uint32_t vertex;
    auto operator<=>(const Need&) const = default;
  };
  std::vector<Need> needs;
  std::vector<std::uint32_t> met;
  for (const mesh::Triangle& t : mesh.triangles) {
    Point low = mesh.vertices[t[0]].position, high = low;
    for (const auto v : t)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], mesh.vertices[v].position[axis]);
        high[axis] = std::max(high[axis], mesh.vertices[v].position[axis]);
      }
    if (cube.contains(low) && cube.contains(high)) continue;
    tree.find(low, high, met);
    for (const auto v : t)
      if (cube.contains(mesh.vertices[v].position))
        for (const auto bucket : met)
          if (tree.cubes()[bucket] != cube) needs.push_back({bucket, v});
  }
  std::sort(needs.begin(), needs.end());
  needs.erase(std::unique(needs.begin(), needs.end()), needs.end());
  std::vector<ForNeighbor> lists;
  std::vector<mesh::Vertex> vertices;
  for (std::size_t i = 0; i < needs.size();) {
    const std::uint32_t bucket = needs[i].bucket;
    vertices.clear();
    for (; i < needs.size() && needs[i].bucket == bucket; ++i)
      vertices.push_back(mesh.vertices[needs[i].vertex]);
    lists.push_back({bucket, 0,
                     workspace.writer.append(static_cast<std::uint32_t>(RecordKind::kAttributes),
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

std::string crowd_text(const Catalog& catalog, const Bucket& bucket) {
  const double side = static_cast<double>(geometry::kRootSide >> bucket.cube.depth);
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

}  // namespace

std::vector<BucketRecord> give_attributes(const Workspace& workspace, Catalog& catalog, Buckets&& buckets,
                                          const Rounding& rounding) {
  const std::vector<std::size_t> filled = filled_buckets(buckets.buckets);
  std::vector<BucketRecord> records(filled.size());
  std::vector<std::vector<ForNeighbor>> lists(filled.size());
  run_phase(
      workspace, "attributes", filled.size(),
      [&](std::size_t i) {
        const Bucket& bucket = buckets.buckets[filled[i]];
        require_memory(workspace, bucket_mesh_bytes(bucket.triangle_count, bucket.vertex_count),
                       crowd_text(catalog, bucket));
        return mesh_task(bucket);
      },
      [&](std::span<const std::byte> task) {
        ByteReader reader(task);
        const auto cube = reader.get<Cube>();
        Piece piece;
        while (reader.remaining() > 0)
          load_piece(workspace, catalog, reader.get<scratch::RecordRef>(), piece);
        BucketMesh bucket(rounding, cube, std::move(piece));
        BucketResult result;
        result.counts = bucket.counts();
        result.lists = tell_neighbors(workspace, buckets.tree, cube, bucket.mesh());
        result.mesh = store(workspace, {std::move(bucket.mesh()), {}});
        return result.to_bytes();
      },
      [&](std::size_t i, const Bytes& bytes) {
        const BucketResult result = BucketResult::from_bytes(bytes);
        records[i].cube = buckets.buckets[filled[i]].cube;
        records[i].triangle_count = buckets.buckets[filled[i]].triangle_count;
        records[i].mesh = result.mesh;
        lists[i] = result.lists;
        catalog.counts.merged_vertices += result.counts.merged_vertices;
        catalog.counts.attribute_seams += result.counts.attribute_seams;
        catalog.counts.duplicate += result.counts.duplicates;
        catalog.counts.border_edges += result.counts.border_edges;
        catalog.counts.nonmanifold_edges += result.counts.nonmanifold_edges;
      });
  broadcast_value(workspace.ranks, catalog.counts);
  // In the order of the buckets, not of arrival: tasks are made of this.
  std::vector<std::size_t> record_of(buckets.buckets.size());
  for (std::size_t i = 0; i < filled.size(); ++i) record_of[filled[i]] = i;
  for (const auto& of_bucket : lists)
    for (const ForNeighbor& list : of_bucket)
      records[record_of[list.bucket]].from_neighbors.push_back(list.record);
  return records;
}

Bytes bucket_task(const BucketRecord& bucket) {
  ByteWriter writer;
  writer.put(bucket.cube);
  writer.put(bucket.mesh);
  writer.put_array<scratch::RecordRef>(bucket.from_neighbors);
  return writer.take();
}

LoadedBucket load_bucket(const Workspace& workspace, std::span<const std::byte> task) {
  ByteReader reader(task);
  LoadedBucket bucket;
  bucket.cube = reader.get<Cube>();
  bucket.mesh = load(workspace, reader.get<scratch::RecordRef>()).mesh;
  std::vector<mesh::Vertex> known;
  while (reader.remaining() > 0) {
    const Bytes bytes = workspace.reader.read(reader.get<scratch::RecordRef>());
    const auto list = ByteReader(bytes).get_array<mesh::Vertex>(bytes.size() / sizeof(mesh::Vertex));
    known.insert(known.end(), list.begin(), list.end());
  }
  const auto is_less = [](const mesh::Vertex& a, const mesh::Vertex& b) { return a.position < b.position; };
  std::sort(known.begin(), known.end(), is_less);
  // Vertices whose triangles have cancelled are nobody's.
  std::vector<bool> is_finished(bucket.mesh.vertices.size(), false);
  for (const mesh::Triangle& t : bucket.mesh.triangles)
    for (const auto i : t) {
      mesh::Vertex& v = bucket.mesh.vertices[i];
      if (is_finished[i] || bucket.cube.contains(v.position)) continue;
      is_finished[i] = true;
      const auto found = std::lower_bound(known.begin(), known.end(), v, is_less);
      COLOSSUS_CHECK(found != known.end() && found->position == v.position, "no attributes for {} {} {}",
                     v.position.x, v.position.y, v.position.z);
      v = *found;
    }
  return bucket;
}

}  // namespace colossus::build
