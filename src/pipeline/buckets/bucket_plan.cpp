#include "pipeline/buckets/bucket_plan.hpp"

#include <algorithm>

#include "pipeline/ingest/radix_sort.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::buckets {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;

// A bucket is one task later: enough of them for many ranks, and each so far above one leaf that its
// ancestors would be split anyway (centroids count duplicates, leaves do not).
constexpr std::uint64_t kLeavesPerBucket = 8;
constexpr std::uint64_t kLeastBucketTriangles = 1 << 17;
constexpr int kMostLevelsPerPass = 7;  // 2^21 counters, 16 MB
// Buckets that are heavier after the first pass are looked into by another one.
constexpr std::uint64_t kMostLimits = 2;
// Counters of all crowded cubes in one pass.
constexpr std::uint64_t kMostCounters = std::uint64_t{1} << 22;

// A cube whose triangles are counted `finer` levels below, if that is not 0.
struct CountedCube {
  CubeId cube;
  std::int32_t finer = 0;
};

struct CellCount {
  std::uint32_t cell = 0;  // counters of all cubes are numbered through
  std::uint32_t count = 0;
};

// Counters of all cubes, one after the other; those of a cube in the order z, y, x.
class Counters {
 public:
  explicit Counters(const std::vector<CountedCube>& cubes) : cubes_(cubes) {
    for (const CountedCube& c : cubes) {
      firsts_.push_back(size_);
      if (c.finer > 0) size_ += std::uint64_t{1} << (3 * c.finer);
    }
  }
  std::uint64_t size() const { return size_; }
  // At the finest level of the cube, counted in the root cube.
  std::uint64_t index(std::size_t cube, std::int32_t x, std::int32_t y, std::int32_t z) const {
    const auto& [at, finer] = cubes_[cube];
    const auto local = [finer = finer](std::int32_t i, std::int32_t of_cube) {
      return static_cast<std::uint64_t>(i - (of_cube << finer));
    };
    return firsts_[cube] + ((local(z, at.z) << finer | local(y, at.y)) << finer | local(x, at.x));
  }

 private:
  const std::vector<CountedCube>& cubes_;
  std::vector<std::uint64_t> firsts_;
  std::uint64_t size_ = 0;
};

class BucketPlanner {
 public:
  BucketPlanner(const run::Workspace& workspace, const facts::Catalog& catalog,
                std::span<const ingest::TriangleGroup> groups, const Rounding& rounding, int most_level)
      : workspace_(workspace),
        catalog_(catalog),
        groups_(groups),
        rounding_(rounding),
        most_level_(most_level),
        limit_(std::max(kLeastBucketTriangles, kLeavesPerBucket * workspace.options.leaf_triangles)),
        cells_of_groups_(groups.size(), 1) {}

  BucketPlan run() {
    cubes_ = {{{0, 0, 0, 0}, levels_for(catalog_.counts.triangles, most_level_)}};
    if (catalog_.counts.triangles <= limit_) cubes_[0].finer = 0;
    for (bool is_first = true;; is_first = false) {
      broadcast_values(workspace_.ranks, cubes_);
      if (std::all_of(cubes_.begin(), cubes_.end(), [](const CountedCube& c) { return c.finer == 0; })) break;
      count_centroids();
      if (workspace_.ranks.is_root()) split_cubes(is_first);
    }
    std::vector<CubeId> cubes;
    for (const CountedCube& c : cubes_) cubes.push_back(c.cube);
    BucketPlan plan{BucketTree(std::move(cubes)), 0};
    for (const std::uint64_t cells : cells_of_groups_)
      plan.piece_count += std::min<std::uint64_t>(cells, cubes_.size());
    broadcast_value(workspace_.ranks, plan.piece_count);
    return plan;
  }

 private:
  // A surface fills about 4^level cubes: two levels more than an even spread would need.
  int levels_for(std::uint64_t triangles, int most) const {
    int levels = 0;
    while (levels < std::min(most, kMostLevelsPerPass) && limit_ << (2 * levels) < triangles * 16) ++levels;
    return levels;
  }

  void count_centroids() {
    std::vector<CubeId> cubes;
    for (const CountedCube& c : cubes_) cubes.push_back(c.cube);
    const BucketTree tree(std::move(cubes));
    const Counters counters(cubes_);
    counts_.assign(workspace_.ranks.is_root() ? counters.size() : 0, 0);
    ++passes_;
    run_phase(
        workspace_, passes_ == 1 ? "centroids" : fmt::format("centroids {}", passes_), groups_.size(),
        [&](std::size_t i) { return group_task(groups_[i]); },
        [&](std::span<const std::byte> task) { return count_group(task, tree, counters); },
        [&](std::size_t i, const Bytes& result) {
          const std::size_t cells = result.size() / sizeof(CellCount);
          cells_of_groups_[i] += cells;
          for (const CellCount& c : ByteReader(result).get_array<CellCount>(cells))
            counts_[c.cell] += c.count;
        });
  }

  Bytes count_group(std::span<const std::byte> task, const BucketTree& tree, const Counters& counters) const {
    const ingest::Piece group = ingest::load_group(workspace_, catalog_, task);
    std::vector<std::uint64_t> cells;
    for (const mesh::Triangle& t : group.triangles) {
      const Point p = rounding_(group.vertices[t[0]].position);
      const Point q = rounding_(group.vertices[t[1]].position);
      const Point r = rounding_(group.vertices[t[2]].position);
      if (mesh::is_degenerate(p, q, r)) continue;
      Point centroid;
      for (int axis = 0; axis < 3; ++axis)
        centroid[axis] = static_cast<std::int32_t>((std::int64_t{p[axis]} + q[axis] + r[axis]) / 3);
      const std::uint32_t cube = tree.at(centroid);
      if (cubes_[cube].finer == 0) continue;
      const int shift = geometry::kRootBits - cubes_[cube].cube.level - cubes_[cube].finer;
      cells.push_back(counters.index(cube, centroid.x >> shift, centroid.y >> shift, centroid.z >> shift));
    }
    ingest::radix_sort(cells, 0, static_cast<int>(std::bit_width(counters.size())));
    ByteWriter result;
    for (std::size_t i = 0; i < cells.size();) {
      CellCount c{static_cast<std::uint32_t>(cells[i]), 0};
      for (; i < cells.size() && cells[i] == c.cell; ++i) ++c.count;
      result.put(c);
    }
    return result.take();
  }

  // Replaces the cubes that were counted by their parts.
  void split_cubes(bool is_first) {
    const Counters counters(cubes_);
    std::vector<CountedCube> next;
    std::uint64_t next_counters = 0;
    for (std::size_t i = 0; i < cubes_.size(); ++i) {
      const CountedCube& c = cubes_[i];
      if (c.finer == 0 || !(is_first || is_thinned_out(counters, i))) {
        next.push_back({c.cube, 0});
        continue;
      }
      descend(counters, i, c.cube, next, next_counters);
    }
    cubes_ = std::move(next);
  }

  void descend(const Counters& counters, std::size_t counted, const CubeId& cube,
               std::vector<CountedCube>& next, std::uint64_t& next_counters) const {
    const int finer = cubes_[counted].cube.level + cubes_[counted].finer - cube.level;
    const std::uint64_t count = sum(counters, counted, cube, finer);
    if (finer > 0 && count > limit_) {
      for (int octant = 0; octant < 8; ++octant)
        descend(counters, counted, cube.child(octant), next, next_counters);
      return;
    }
    int levels = count > kMostLimits * limit_ ? levels_for(count, most_level_ - cube.level) : 0;
    if (next_counters + (std::uint64_t{1} << (3 * levels)) > kMostCounters) levels = 0;
    if (levels > 0) next_counters += std::uint64_t{1} << (3 * levels);
    next.push_back({cube, levels});
  }

  std::uint64_t sum(const Counters& counters, std::size_t counted, const CubeId& cube, int finer) const {
    std::uint64_t sum = 0;
    for (std::int32_t z = cube.z << finer; z < (cube.z + 1) << finer; ++z)
      for (std::int32_t y = cube.y << finer; y < (cube.y + 1) << finer; ++y)
        for (std::int32_t x = cube.x << finer; x < (cube.x + 1) << finer; ++x)
          sum += counts_[counters.index(counted, x, y, z)];
    return sum;
  }

  // Else all would be split to the level that was counted, and the bucket would be no smaller.
  bool is_thinned_out(const Counters& counters, std::size_t counted) const {
    const CubeId& cube = cubes_[counted].cube;
    const int finer = cubes_[counted].finer;
    std::uint64_t whole = 0;
    std::uint64_t most = 0;
    const std::uint64_t first = counters.index(counted, cube.x << finer, cube.y << finer, cube.z << finer);
    for (std::uint64_t i = first; i < first + (std::uint64_t{1} << (3 * finer)); ++i) {
      whole += counts_[i];
      most = std::max(most, counts_[i]);
    }
    return most * 10 <= whole * 9;
  }

  const run::Workspace& workspace_;
  const facts::Catalog& catalog_;
  std::span<const ingest::TriangleGroup> groups_;
  Rounding rounding_;
  int most_level_;
  std::uint64_t limit_;
  int passes_ = 0;
  std::vector<CountedCube> cubes_;     // as many as tile the root cube
  std::vector<std::uint64_t> counts_;  // on rank 0
  std::vector<std::uint64_t> cells_of_groups_;
};

}  // namespace

BucketPlan plan_buckets(const run::Workspace& workspace, const facts::Catalog& catalog,
                        std::span<const ingest::TriangleGroup> groups, const Rounding& rounding,
                        int most_level) {
  return BucketPlanner(workspace, catalog, groups, rounding, most_level).run();
}

}  // namespace colossus::pipeline::buckets
