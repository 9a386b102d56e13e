#include "pipeline/diamonds/partition.hpp"

#include <algorithm>
#include <unordered_map>

#include "mesh/clip.hpp"
#include "pipeline/buckets/attributes.hpp"
#include "pipeline/diamonds/cut_remains.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::diamonds {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using hierarchy::Diamond;
using hierarchy::Point;
using hierarchy::Tetrahedron;
using mesh::Mesh;

// Slivers that every plane cuts would multiply without end: a tenth fewer in the larger half, but twice as
// many in all.
constexpr double kMostGrowth = 8.0;

// What a bucket or a forced split gives back.
struct Refinement {
  std::vector<TetrahedronRecord> leaves;
  std::vector<Point> splits;
  std::uint64_t revived = 0;  // pairs of triangles, see revive_lost()

  Bytes to_bytes() const {
    ByteWriter writer;
    writer.put(std::array<std::uint64_t, 3>{leaves.size(), splits.size(), revived});
    writer.put_array<TetrahedronRecord>(leaves);
    writer.put_array<Point>(splits);
    return writer.take();
  }
  static Refinement from_bytes(const Bytes& bytes) {
    ByteReader reader(bytes);
    const auto counts = reader.get<std::array<std::uint64_t, 3>>();
    Refinement refinement;
    refinement.revived = counts[2];
    refinement.leaves = reader.get_array<TetrahedronRecord>(counts[0]);
    refinement.splits = reader.get_array<Point>(counts[1]);
    COLOSSUS_CHECK(!reader.failed());
    return refinement;
  }
};

// Bisects one tetrahedron's mesh as far as it must and may.
class Refiner {
 public:
  Refiner(const run::Workspace& workspace, const DiamondSet& splits)
      : workspace_(workspace), splits_(splits) {}

  // `growth` is how many times as many pieces the cuts have made on the way here.
  void refine(const Tetrahedron& tetrahedron, Mesh&& mesh, double growth, Refinement& out) {
    if (mesh.triangles.empty()) return;
    const Point center = tetrahedron.center();
    const bool is_forced = splits_.contains(center);
    if (!is_forced && (growth > kMostGrowth || !is_worth_splitting(tetrahedron, mesh))) {
      out.revived += weld_cut(tetrahedron, mesh);
      if (!mesh.triangles.empty())
        out.leaves.push_back(
            store_tetrahedron(workspace_, hierarchy::id_of(tetrahedron), {std::move(mesh), {}}));
      return;
    }
    if (!is_forced) out.splits.push_back(center);
    split_into(tetrahedron, std::move(mesh), growth, out);
  }

  void split_into(const Tetrahedron& tetrahedron, Mesh&& mesh, double growth, Refinement& out) {
    auto halves = mesh::split(mesh, tetrahedron.bisector());
    growth *= static_cast<double>(halves[0].triangles.size() + halves[1].triangles.size()) /
              static_cast<double>(mesh.triangles.size());
    mesh = {};
    refine(tetrahedron.child(0), std::move(halves[0]), growth, out);
    refine(tetrahedron.child(1), std::move(halves[1]), growth, out);
  }

 private:
  bool is_worth_splitting(const Tetrahedron& tetrahedron, const Mesh& mesh) const {
    if (mesh.triangles.size() <= workspace_.options.leaf_triangles) return false;
    Tetrahedron at = tetrahedron;
    const Mesh* current = &mesh;
    Mesh kept;
    while (hierarchy::level_of(at.center()) < hierarchy::kMaxLevel) {
      auto halves = mesh::split(*current, at.bisector());
      const std::size_t whole = current->triangles.size();
      const std::size_t greater = halves[0].triangles.size() >= halves[1].triangles.size() ? 0 : 1;
      const std::size_t most = halves[greater].triangles.size();
      if (most * 10 <= whole * 9) return true;
      if ((most + halves[1 - greater].triangles.size()) * 20 > whole * 21) return false;
      kept = std::move(halves[greater]);
      current = &kept;
      at = at.child(static_cast<int>(greater));
    }
    return false;
  }

  const run::Workspace& workspace_;
  const DiamondSet& splits_;
};

// Cuts a bucket's triangles from the root on, following only tetrahedra that reach into its cube: everybody
// enters through the same sequence of planes.
class BucketCutter {
 public:
  BucketCutter(const hierarchy::CubeId& cube, Refiner& refiner, Refinement& out)
      : refiner_(refiner), out_(out) {
    const std::int64_t side = std::int64_t{geometry::kRootSide} >> cube.level;
    low_ = {static_cast<std::int32_t>(cube.x * side), static_cast<std::int32_t>(cube.y * side),
            static_cast<std::int32_t>(cube.z * side)};
    high_ = {static_cast<std::int32_t>(low_.x + side), static_cast<std::int32_t>(low_.y + side),
             static_cast<std::int32_t>(low_.z + side)};
    level_ = 3 * cube.level;
  }

  void cut(Mesh&& mesh) {
    const auto planes = hierarchy::root_planes();
    const Diamond root = Diamond::at(hierarchy::root_center());
    auto by_xy = mesh::split(mesh, planes[0]);
    mesh = {};
    for (std::size_t i = 0; i < 2; ++i) {
      auto by_yz = mesh::split(by_xy[i], planes[1]);
      for (std::size_t j = 0; j < 2; ++j) {
        auto by_xz = mesh::split(by_yz[j], planes[2]);
        for (std::size_t k = 0; k < 2; ++k) enter(root, {i == 0, j == 0, k == 0}, std::move(by_xz[k]));
      }
    }
  }

 private:
  // The root tetrahedron on the given sides of the three planes; two of the eight combinations have none.
  void enter(const Diamond& root, const std::array<bool, 3>& is_above, Mesh&& mesh) {
    if (mesh.triangles.empty()) return;
    const auto planes = hierarchy::root_planes();
    for (int place = 0; place < root.place_count; ++place) {
      const Tetrahedron& t = root.tetrahedra[static_cast<std::size_t>(place)];
      bool is_here = true;
      for (std::size_t p = 0; p < 3; ++p)
        for (const Point& corner : t.corners)
          is_here &= is_above[p] ? planes[p].side(corner) >= 0 : planes[p].side(corner) <= 0;
      if (!is_here) continue;
      descend(t, 0, std::move(mesh));
      return;
    }
  }

  void descend(const Tetrahedron& tetrahedron, int level, Mesh&& mesh) {
    if (mesh.triangles.empty() || !reaches_into_cube(tetrahedron)) return;
    if (level == level_) {
      refiner_.refine(tetrahedron, std::move(mesh), 1.0, out_);
      return;
    }
    out_.splits.push_back(tetrahedron.center());
    auto halves = mesh::split(mesh, tetrahedron.bisector());
    mesh = {};
    descend(tetrahedron.child(0), level + 1, std::move(halves[0]));
    descend(tetrahedron.child(1), level + 1, std::move(halves[1]));
  }

  bool reaches_into_cube(const Tetrahedron& t) const {
    for (int axis = 0; axis < 3; ++axis) {
      std::int32_t least = t.corners[0][axis];
      std::int32_t most = least;
      for (const Point& corner : t.corners) {
        least = std::min(least, corner[axis]);
        most = std::max(most, corner[axis]);
      }
      if (most <= low_[axis] || least >= high_[axis]) return false;
    }
    return true;
  }

  Refiner& refiner_;
  Refinement& out_;
  Point low_;
  Point high_;
  int level_ = 0;
};

class Partitioner {
 public:
  Partitioner(const run::Workspace& workspace, facts::Catalog& catalog,
              std::vector<ingest::TriangleGroup>&& groups)
      : workspace_(workspace), catalog_(catalog), groups_(std::move(groups)) {}

  Partition run() {
    cut_buckets();
    while (complete_diamonds()) {
    }
    partition_.last_phase = last_phase(workspace_);
    std::sort(partition_.leaves.begin(), partition_.leaves.end(), [](const auto& a, const auto& b) {
      const int level_a = hierarchy::level_of(a.id.center);
      const int level_b = hierarchy::level_of(b.id.center);
      return level_a != level_b ? level_a < level_b : a.id < b.id;
    });
    return std::move(partition_);
  }

 private:
  void cut_buckets() {
    const std::vector<buckets::BucketRecord> buckets =
        buckets::make_buckets(workspace_, catalog_, std::move(groups_), {}, {hierarchy::kMaxLevel / 3});
    std::vector<Refinement> results(buckets.size());
    run_phase(
        workspace_, "partition", buckets.size(), [&](std::size_t i) { return bucket_task(buckets[i]); },
        [&](std::span<const std::byte> task) {
          buckets::LoadedBucket bucket = buckets::load_bucket(workspace_, task);
          Refinement out;
          out.revived += revive_lost(bucket.lost, geometry::kInputSpacing, bucket.cube, bucket.mesh).pairs;
          Refiner refiner(workspace_, partition_.splits);
          BucketCutter(bucket.cube, refiner, out).cut(std::move(bucket.mesh));
          return out.to_bytes();
        },
        [&](std::size_t i, const Bytes& result) { results[i] = Refinement::from_bytes(result); });
    partition_.first_phase = last_phase(workspace_);
    release_phases_up_to(workspace_, partition_.first_phase - 1);
    for (Refinement& result : results) take(std::move(result));
    share_splits();
  }

  void take(Refinement&& result) {
    partition_.leaves.insert(partition_.leaves.end(), result.leaves.begin(), result.leaves.end());
    partition_.revived += result.revived;
    new_splits_.insert(new_splits_.end(), result.splits.begin(), result.splits.end());
  }

  // Closes the new splits under parents and tells all ranks.
  void share_splits() {
    std::vector<Point> closed;
    std::vector<Point> pending = std::move(new_splits_);
    new_splits_.clear();
    while (!pending.empty()) {
      const Point center = pending.back();
      pending.pop_back();
      if (!partition_.splits.insert(center).second) continue;
      closed.push_back(center);
      for (const Point& parent : Diamond::at(center).parents()) pending.push_back(parent);
    }
    broadcast_values(workspace_.ranks, closed);
    partition_.splits.insert(closed.begin(), closed.end());
  }

  // Splits the leaves whose diamonds are split elsewhere. False when there was nothing to do. Collective.
  bool complete_diamonds() {
    std::vector<TetrahedronRecord> forced;
    if (workspace_.ranks.is_root()) {
      const auto is_forced = [&](const TetrahedronRecord& leaf) {
        return partition_.splits.contains(leaf.id.center);
      };
      std::copy_if(partition_.leaves.begin(), partition_.leaves.end(), std::back_inserter(forced), is_forced);
      std::erase_if(partition_.leaves, is_forced);
    }
    std::uint64_t count = forced.size();
    broadcast_value(workspace_.ranks, count);
    if (count == 0) return false;
    std::vector<Refinement> results(forced.size());
    run_phase(
        workspace_, fmt::format("completion {}", ++completions_), forced.size(),
        [&](std::size_t i) {
          ByteWriter writer;
          writer.put(forced[i]);
          return writer.take();
        },
        [&](std::span<const std::byte> task) {
          const auto leaf = ByteReader(task).get<TetrahedronRecord>();
          Refinement out;
          // A leaf above the limit was not worth splitting; its halves are split no further than others
          // demand.
          const double growth = leaf.triangles > workspace_.options.leaf_triangles ? kMostGrowth + 1.0 : 1.0;
          Refiner(workspace_, partition_.splits)
              .split_into(hierarchy::tetrahedron_of(leaf.id),
                          std::move(nodes::load(workspace_, leaf.record).mesh), growth, out);
          return out.to_bytes();
        },
        [&](std::size_t i, const Bytes& result) { results[i] = Refinement::from_bytes(result); });
    for (Refinement& result : results) take(std::move(result));
    share_splits();
    return true;
  }

  const run::Workspace& workspace_;
  facts::Catalog& catalog_;
  std::vector<ingest::TriangleGroup> groups_;
  Partition partition_;
  std::vector<Point> new_splits_;  // on rank 0
  int completions_ = 0;
};

}  // namespace

Partition partition(const run::Workspace& workspace, facts::Catalog& catalog,
                    std::vector<ingest::TriangleGroup>&& groups) {
  return Partitioner(workspace, catalog, std::move(groups)).run();
}

}  // namespace colossus::pipeline::diamonds
