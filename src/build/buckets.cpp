#include "build/buckets.hpp"

#include <algorithm>

#include "build/phase.hpp"

namespace colossus::build {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;

struct BucketPiece {
  std::uint32_t bucket = 0;
  std::uint32_t padding = 0;
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;
  scratch::RecordRef record;
};

// Which triangles of a group go to which buckets.
class Assignment {
 public:
  Assignment(const Piece& group, const Rounding& rounding, const BucketTree& tree) {
    std::vector<std::uint32_t> met;
    for (std::uint32_t i = 0; i < group.triangles.size(); ++i) {
      std::array<Point, 3> p;
      for (std::size_t k = 0; k < 3; ++k) p[k] = group.vertices[group.triangles[i][k]].position;
      if (mesh::is_degenerate(p[0], p[1], p[2])) {
        ++degenerate_;
        continue;
      }
      for (Point& corner : p) corner = rounding(corner);
      if (mesh::is_degenerate(p[0], p[1], p[2])) ++degenerate_;
      Point low = p[0], high = p[0];
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min({p[0][axis], p[1][axis], p[2][axis]});
        high[axis] = std::max({p[0][axis], p[1][axis], p[2][axis]});
      }
      tree.find(low, high, met);
      for (const auto bucket : met) assigned_.push_back({bucket, i});
    }
    std::stable_sort(assigned_.begin(), assigned_.end(),
                     [](const Assigned& a, const Assigned& b) { return a.bucket < b.bucket; });
  }

  std::uint64_t degenerate() const { return degenerate_; }

  // Calls visit(bucket, triangles) for each bucket, ascending.
  template <typename Visit>
  void for_each_bucket(const Visit& visit) const {
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 0; i < assigned_.size();) {
      const std::uint32_t bucket = assigned_[i].bucket;
      triangles.clear();
      for (; i < assigned_.size() && assigned_[i].bucket == bucket; ++i)
        triangles.push_back(assigned_[i].triangle);
      visit(bucket, triangles);
    }
  }

 private:
  struct Assigned {
    std::uint32_t bucket;
    std::uint32_t triangle;
  };
  std::vector<Assigned> assigned_;
  std::uint64_t degenerate_ = 0;
};

}  // namespace

Buckets fill_buckets(const Workspace& workspace, Catalog& catalog, std::span<const TriangleGroup> groups,
                     const Rounding& rounding, int most_depth) {
  Buckets result{plan_buckets(workspace, catalog, groups, rounding, most_depth), {}};
  std::vector<std::vector<BucketPiece>> pieces(groups.size());
  run_phase(
      workspace, "buckets", groups.size(), [&](std::size_t i) { return group_task(groups[i]); },
      [&](std::span<const std::byte> task) {
        const Piece group = load_group(workspace, catalog, task);
        const Assignment assignment(group, rounding, result.tree);
        PieceCutter cutter(group);
        ByteWriter writer;
        writer.put(assignment.degenerate());
        assignment.for_each_bucket([&](std::uint32_t bucket, std::span<const std::uint32_t> triangles) {
          const Piece piece = cutter.take(triangles);
          writer.put(BucketPiece{bucket, 0, static_cast<std::uint32_t>(piece.triangles.size()),
                                 static_cast<std::uint32_t>(piece.vertices.size()),
                                 store_piece(workspace, catalog, piece)});
        });
        return writer.take();
      },
      [&](std::size_t i, const Bytes& bytes) {
        ByteReader reader(bytes);
        catalog.counts.degenerate += reader.get<std::uint64_t>();
        pieces[i] = reader.get_array<BucketPiece>(reader.remaining() / sizeof(BucketPiece));
        COLOSSUS_CHECK(!reader.failed());
      });
  if (!workspace.ranks.is_root()) return result;
  for (const Cube& cube : result.tree.cubes()) result.buckets.push_back({cube, 0, 0, {}});
  for (auto& of_group : pieces) {
    for (const BucketPiece& piece : of_group) {
      Bucket& bucket = result.buckets[piece.bucket];
      bucket.triangle_count += piece.triangles;
      bucket.vertex_count += piece.vertices;
      bucket.pieces.push_back(piece.record);
    }
    of_group = {};
  }
  return result;
}

}  // namespace colossus::build
