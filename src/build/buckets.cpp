#include "build/buckets.hpp"

#include <algorithm>
#include <optional>

#include "build/phase.hpp"

namespace colossus::build {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;

// A bucket is one task later: enough of them for many ranks, and each so far above one leaf that its
// ancestors would be split anyway (centroids count duplicates, leaves do not).
constexpr std::uint64_t kLeavesPerBucket = 8;
constexpr std::uint64_t kLeastBucketTriangles = 1 << 17;
constexpr int kMaxDepth = 7;  // 2^21 counters, 16 MB

struct BucketPiece {
  std::uint32_t bucket = 0;
  std::uint32_t count = 0;
  scratch::RecordRef record;
};

class BucketFiller {
 public:
  BucketFiller(const Workspace& workspace, Catalog& catalog, int most_depth)
      : workspace_(workspace),
        catalog_(catalog),
        most_depth_(std::min(most_depth, kMaxDepth)),
        mapped_(workspace.scratch) {}

  std::vector<Bucket> run() {
    workspace_.ranks.attempt([&] { store_.emplace(catalog_.vertex_blocks, mapped_); });
    choose_depth();
    count_centroids();
    cells_.assign(std::size_t{1} << (3 * depth_), 0);
    descend({0, 0, 0, 0});
    distribute();
    return std::move(buckets_);
  }

 private:
  std::uint64_t bucket_limit() const {
    return std::max(kLeastBucketTriangles, kLeavesPerBucket * workspace_.options.leaf_triangles);
  }

  // A surface fills about 4^depth cubes: two levels more than an even spread would need.
  void choose_depth() {
    depth_ = 0;
    while (depth_ < most_depth_ && bucket_limit() << (2 * depth_) < catalog_.counts.triangles * 16) ++depth_;
    if (catalog_.counts.triangles <= bucket_limit()) depth_ = 0;
  }

  std::size_t cell_index(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z) << depth_ | static_cast<std::size_t>(y)) << depth_ |
           static_cast<std::size_t>(x);
  }

  template <typename Visit>
  void for_each_triangle(std::size_t block_index, const Visit& visit) {
    const TriangleBlockRef& block = catalog_.triangle_blocks[block_index];
    const Bytes bytes = workspace_.reader.read(block.record);
    for (const auto& t : ByteReader(bytes).get_array<mesh::Triangle>(block.count)) {
      const BucketTriangle v{block.first_vertex + t[0], block.first_vertex + t[1], block.first_vertex + t[2]};
      visit(v, (*store_)[v[0]].position, (*store_)[v[1]].position, (*store_)[v[2]].position);
    }
  }

  void count_centroids() {
    std::vector<std::uint64_t> counts(std::size_t{1} << (3 * depth_), 0);
    std::uint64_t degenerate = 0;
    const int shift = geometry::kRootBits - depth_;
    workspace_.ranks.attempt([&] {
      for_my_share(workspace_.ranks, catalog_.triangle_blocks.size(), [&](std::size_t i) {
        for_each_triangle(i, [&](const BucketTriangle&, const Point& p, const Point& q, const Point& r) {
          if (mesh::is_degenerate(p, q, r)) {
            ++degenerate;
            return;
          }
          const auto cell = [&](int axis) {
            return static_cast<std::int32_t>((std::int64_t{p[axis]} + q[axis] + r[axis]) / 3 >> shift);
          };
          ++counts[cell_index(cell(0), cell(1), cell(2))];
        });
      });
    });
    workspace_.ranks.all_sum(std::span<std::uint64_t>(counts));
    catalog_.counts.degenerate = workspace_.ranks.sum(degenerate);
    counts_ = std::move(counts);
  }

  std::uint64_t count_in(const Cube& cube) const {
    const int finer = depth_ - cube.depth;
    std::uint64_t sum = 0;
    for (std::int32_t z = cube.z << finer; z < (cube.z + 1) << finer; ++z)
      for (std::int32_t y = cube.y << finer; y < (cube.y + 1) << finer; ++y)
        for (std::int32_t x = cube.x << finer; x < (cube.x + 1) << finer; ++x)
          sum += counts_[cell_index(x, y, z)];
    return sum;
  }

  void descend(const Cube& cube) {
    if (cube.depth < depth_ && count_in(cube) > bucket_limit()) {
      for (int child = 0; child < 8; ++child)
        descend({cube.depth + 1, 2 * cube.x + (child & 1), 2 * cube.y + (child >> 1 & 1),
                 2 * cube.z + (child >> 2)});
      return;
    }
    const int finer = depth_ - cube.depth;
    for (std::int32_t z = cube.z << finer; z < (cube.z + 1) << finer; ++z)
      for (std::int32_t y = cube.y << finer; y < (cube.y + 1) << finer; ++y)
        for (std::int32_t x = cube.x << finer; x < (cube.x + 1) << finer; ++x)
          cells_[cell_index(x, y, z)] = static_cast<std::uint32_t>(buckets_.size());
    buckets_.push_back({cube, {}, 0});
  }

  // One task per block of triangles: a record for each bucket that it touches.
  void distribute() {
    std::vector<std::vector<BucketPiece>> pieces(catalog_.triangle_blocks.size());
    run_phase(
        workspace_, "buckets", catalog_.triangle_blocks.size(),
        [](std::size_t i) {
          ByteWriter writer;
          writer.put(i);
          return writer.take();
        },
        [&](std::span<const std::byte> task) {
          return distribute_block(ByteReader(task).get<std::size_t>());
        },
        [&](std::size_t i, Bytes result) {
          pieces[i] = ByteReader(result).get_array<BucketPiece>(result.size() / sizeof(BucketPiece));
        });
    for (const auto& of_block : pieces)
      for (const BucketPiece& piece : of_block) {
        buckets_[piece.bucket].records.push_back(piece.record);
        buckets_[piece.bucket].triangle_count += piece.count;
      }
  }

  Bytes distribute_block(std::size_t block) {
    struct Assigned {
      std::uint32_t bucket;
      BucketTriangle triangle;
    };
    std::vector<Assigned> assigned;
    std::vector<std::uint32_t> touched;
    for_each_triangle(block, [&](const BucketTriangle& t, const Point& p, const Point& q, const Point& r) {
      if (mesh::is_degenerate(p, q, r)) return;
      find_buckets(p, q, r, touched);
      for (const auto bucket : touched) assigned.push_back({bucket, t});
    });
    std::stable_sort(assigned.begin(), assigned.end(),
                     [](const Assigned& a, const Assigned& b) { return a.bucket < b.bucket; });
    std::vector<BucketPiece> pieces;
    std::vector<BucketTriangle> triangles;
    for (std::size_t i = 0; i < assigned.size();) {
      triangles.clear();
      const std::uint32_t bucket = assigned[i].bucket;
      for (; i < assigned.size() && assigned[i].bucket == bucket; ++i)
        triangles.push_back(assigned[i].triangle);
      pieces.push_back({bucket, static_cast<std::uint32_t>(triangles.size()),
                        workspace_.writer.append(static_cast<std::uint32_t>(RecordKind::kBucket),
                                                 core::as_bytes(triangles))});
    }
    const auto view = core::as_bytes(pieces);
    return {view.begin(), view.end()};
  }

  void find_buckets(const Point& p, const Point& q, const Point& r,
                    std::vector<std::uint32_t>& touched) const {
    const int shift = geometry::kRootBits - depth_;
    std::array<std::int32_t, 3> low;
    std::array<std::int32_t, 3> high;
    for (int axis = 0; axis < 3; ++axis) {
      low[static_cast<std::size_t>(axis)] = std::min({p[axis], q[axis], r[axis]}) >> shift;
      high[static_cast<std::size_t>(axis)] = std::max({p[axis], q[axis], r[axis]}) >> shift;
    }
    touched.clear();
    for (std::int32_t z = low[2]; z <= high[2]; ++z)
      for (std::int32_t y = low[1]; y <= high[1]; ++y)
        for (std::int32_t x = low[0]; x <= high[0]; ++x) touched.push_back(cells_[cell_index(x, y, z)]);
    if (touched.size() == 1) return;
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  }

  const Workspace& workspace_;
  Catalog& catalog_;
  int most_depth_;
  scratch::MappedSpool mapped_;
  std::optional<VertexStore> store_;
  int depth_ = 0;
  std::vector<std::uint64_t> counts_;
  std::vector<std::uint32_t> cells_;  // the bucket of each cell
  std::vector<Bucket> buckets_;
};

}  // namespace

std::vector<std::size_t> filled_buckets(const std::vector<Bucket>& buckets) {
  std::vector<std::size_t> filled;
  for (std::size_t i = 0; i < buckets.size(); ++i)
    if (buckets[i].triangle_count > 0) filled.push_back(i);
  std::stable_sort(filled.begin(), filled.end(), [&](std::size_t a, std::size_t b) {
    return buckets[a].triangle_count > buckets[b].triangle_count;
  });
  return filled;
}

core::Bytes bucket_task(const Bucket& bucket) {
  ByteWriter writer;
  writer.put(bucket.cube);
  writer.put_array<scratch::RecordRef>(bucket.records);
  return writer.take();
}

Bucket bucket_of_task(std::span<const std::byte> task) {
  ByteReader reader(task);
  Bucket bucket;
  bucket.cube = reader.get<Cube>();
  bucket.records = reader.get_array<scratch::RecordRef>(reader.remaining() / sizeof(scratch::RecordRef));
  return bucket;
}

std::vector<Bucket> fill_buckets(const Workspace& workspace, Catalog& catalog, int most_depth) {
  return BucketFiller(workspace, catalog, most_depth).run();
}

}  // namespace colossus::build
