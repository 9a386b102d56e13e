#include "pipeline/buckets/buckets.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::buckets {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;

// Of the second step's tasks.
constexpr std::uint64_t kMostTaskTriangles = std::uint64_t{1} << 19;

struct BucketPiece {
  std::uint32_t target = 0;  // a bucket, or a run of them
  std::uint32_t padding = 0;
  std::uint32_t triangles = 0;
  std::uint32_t vertices = 0;
  scratch::RecordRef record;
};

// Where triangles go: to runs of `per_target` buckets. Only those in the run `within` are of interest, a run
// of `per_run` buckets.
struct Targets {
  std::uint32_t per_target = 1;
  std::uint32_t per_run = ~std::uint32_t{0};
  std::uint32_t within = 0;
};

// Which triangles of a piece go to which targets.
class Assignment {
 public:
  Assignment(const ingest::Piece& piece, const Rounding& rounding, const BucketTree& tree,
             const Targets& targets) {
    std::vector<std::uint32_t> met;
    for (std::uint32_t i = 0; i < piece.triangles.size(); ++i) {
      if (is_degenerate(piece, piece.triangles[i])) {
        ++degenerate_;
        continue;
      }
      std::array<Point, 3> p;
      for (std::size_t k = 0; k < 3; ++k) p[k] = rounding(piece.vertices[piece.triangles[i][k]].position);
      if (mesh::is_degenerate(p[0], p[1], p[2])) ++collapsed_;
      Point low, high;
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min({p[0][axis], p[1][axis], p[2][axis]});
        high[axis] = std::max({p[0][axis], p[1][axis], p[2][axis]});
      }
      tree.find(low, high, met);
      assign(met, i, targets);
    }
    std::stable_sort(assigned_.begin(), assigned_.end(),
                     [](const Assigned& a, const Assigned& b) { return a.target < b.target; });
  }

  // Triangles that had two equal corners when they were read.
  std::uint64_t degenerate() const { return degenerate_; }
  // Triangles that have lost a corner to lattice or rounding.
  std::uint64_t collapsed() const { return collapsed_; }

  // Calls visit(target, triangles) for each target, ascending.
  template <typename Visit>
  void for_each_target(const Visit& visit) const {
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 0; i < assigned_.size();) {
      const std::uint32_t target = assigned_[i].target;
      triangles.clear();
      for (; i < assigned_.size() && assigned_[i].target == target; ++i)
        triangles.push_back(assigned_[i].triangle);
      visit(target, triangles);
    }
  }

 private:
  struct Assigned {
    std::uint32_t target;
    std::uint32_t triangle;
  };

  static bool is_degenerate(const ingest::Piece& piece, const mesh::Triangle& t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const mesh::Vertex& a = piece.vertices[t[k]];
      const mesh::Vertex& b = piece.vertices[t[(k + 1) % 3]];
      if (a.position == b.position && a.fingerprint == b.fingerprint) return true;
    }
    return false;
  }

  // `met` ascends, so that those of one target follow each other.
  void assign(const std::vector<std::uint32_t>& met, std::uint32_t triangle, const Targets& targets) {
    for (std::size_t i = 0; i < met.size(); ++i) {
      const std::uint32_t target = met[i] / targets.per_target;
      if (i > 0 && target == met[i - 1] / targets.per_target) continue;
      if (met[i] / targets.per_run == targets.within) assigned_.push_back({target, triangle});
    }
  }

  std::vector<Assigned> assigned_;
  std::uint64_t degenerate_ = 0;
  std::uint64_t collapsed_ = 0;
};

class BucketFiller {
 public:
  BucketFiller(const run::Workspace& workspace, facts::Catalog& catalog,
               std::span<const ingest::TriangleGroup> groups, const Rounding& rounding, BucketPlan&& plan)
      : workspace_(workspace),
        catalog_(catalog),
        groups_(groups),
        rounding_(rounding),
        tree_(std::move(plan.tree)) {}

  Buckets run(bool in_two_steps) {
    std::vector<std::vector<BucketPiece>> pieces =
        in_two_steps ? from_runs(from_groups("runs of buckets", buckets_per_run()))
                     : from_groups("buckets", 1);
    Buckets result{std::move(tree_), {}};
    if (!workspace_.ranks.is_root()) return result;
    for (const CubeId& cube : result.tree.cubes()) result.buckets.push_back({cube, 0, 0, {}});
    for (auto& of_task : pieces) {
      for (const BucketPiece& piece : of_task) {
        Bucket& bucket = result.buckets[piece.target];
        bucket.triangle_count += piece.triangles;
        bucket.vertex_count += piece.vertices;
        bucket.pieces.push_back(piece.record);
      }
      of_task = {};
    }
    return result;
  }

 private:
  // As many runs as buckets in each.
  std::uint32_t buckets_per_run() const {
    return static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(tree_.cubes().size()))));
  }

  std::vector<std::vector<BucketPiece>> from_groups(const std::string& name, std::uint32_t per_target) {
    std::vector<std::vector<BucketPiece>> pieces(groups_.size());
    run_phase(
        workspace_, name, groups_.size(), [&](std::size_t i) { return group_task(groups_[i]); },
        [&](std::span<const std::byte> task) {
          return distribute(ingest::load_group(workspace_, catalog_, task), {per_target});
        },
        [&](std::size_t i, const Bytes& bytes) { pieces[i] = take(bytes, true); });
    return pieces;
  }

  // The pieces of a run, in the order of the input's faces, are joined to about the size of a group again.
  std::vector<std::vector<BucketPiece>> from_runs(std::vector<std::vector<BucketPiece>>&& of_groups) {
    std::vector<std::vector<BucketPiece>> of_runs(tree_.cubes().size() / buckets_per_run() + 1);
    for (auto& of_group : of_groups) {
      for (const BucketPiece& piece : of_group) of_runs[piece.target].push_back(piece);
      of_group = {};
    }
    std::vector<std::vector<BucketPiece>> tasks;
    for (auto& of_run : of_runs) {
      std::uint64_t triangles = kMostTaskTriangles;
      for (const BucketPiece& piece : of_run) {
        if (triangles >= kMostTaskTriangles) {
          tasks.emplace_back();
          triangles = 0;
        }
        tasks.back().push_back(piece);
        triangles += piece.triangles;
      }
      of_run = {};
    }
    std::vector<std::vector<BucketPiece>> pieces(tasks.size());
    run_phase(
        workspace_, "buckets", tasks.size(),
        [&](std::size_t i) {
          ByteWriter writer;
          writer.put_array<BucketPiece>(tasks[i]);
          return writer.take();
        },
        [&](std::span<const std::byte> task) {
          const auto parts = ByteReader(task).get_array<BucketPiece>(task.size() / sizeof(BucketPiece));
          ingest::Piece piece;
          for (const BucketPiece& part : parts) load_piece(workspace_, catalog_, part.record, piece);
          return distribute(piece, {1, buckets_per_run(), parts.at(0).target});
        },
        [&](std::size_t i, const Bytes& bytes) { pieces[i] = take(bytes, false); });
    return pieces;
  }

  Bytes distribute(const ingest::Piece& piece, const Targets& targets) const {
    const Assignment assignment(piece, rounding_, tree_, targets);
    ingest::PieceCutter cutter(piece);
    ByteWriter writer;
    writer.put(assignment.degenerate());
    writer.put(assignment.collapsed());
    assignment.for_each_target([&](std::uint32_t target, std::span<const std::uint32_t> triangles) {
      const ingest::Piece part = cutter.take(triangles);
      writer.put(BucketPiece{target, 0, static_cast<std::uint32_t>(part.triangles.size()),
                             static_cast<std::uint32_t>(part.vertices.size()),
                             store_piece(workspace_, catalog_, part)});
    });
    return writer.take();
  }

  std::vector<BucketPiece> take(const Bytes& bytes, bool is_first) {
    ByteReader reader(bytes);
    const auto degenerate = reader.get<std::uint64_t>();
    const auto collapsed = reader.get<std::uint64_t>();
    if (is_first) {
      catalog_.counts.degenerate += degenerate;
      catalog_.counts.collapsed += collapsed;
    }
    auto pieces = reader.get_array<BucketPiece>(reader.remaining() / sizeof(BucketPiece));
    COLOSSUS_CHECK(!reader.failed());
    return pieces;
  }

  const run::Workspace& workspace_;
  facts::Catalog& catalog_;
  std::span<const ingest::TriangleGroup> groups_;
  Rounding rounding_;
  BucketTree tree_;
};

}  // namespace

Buckets fill_buckets(const run::Workspace& workspace, facts::Catalog& catalog,
                     std::span<const ingest::TriangleGroup> groups, const Rounding& rounding,
                     const BucketOptions& options) {
  BucketPlan plan = plan_buckets(workspace, catalog, groups, rounding, options.most_level);
  const bool in_two_steps = plan.piece_count > options.most_pieces;
  return BucketFiller(workspace, catalog, groups, rounding, std::move(plan)).run(in_two_steps);
}

}  // namespace colossus::pipeline::buckets
