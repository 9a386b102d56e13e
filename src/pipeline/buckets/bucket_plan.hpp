// Chooses the buckets: the cubes of a coarse octree, made from exact counts of centroids.
#pragma once

#include "pipeline/buckets/bucket_tree.hpp"
#include "pipeline/ingest/join.hpp"

namespace colossus::pipeline::buckets {

// Moves positions to multiples of `spacing`, a power of two. A spacing of 0 leaves them as they are.
struct Rounding {
  std::int32_t spacing = 0;
  bool is_none() const { return spacing == 0; }
  geometry::Point operator()(geometry::Point p) const {
    if (is_none()) return p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = (p[axis] + spacing / 2) & ~(spacing - 1);
    return p;
  }
};

struct BucketPlan {
  BucketTree tree;
  // At most so many pairs of a group and a bucket that it has centroids in.
  std::uint64_t piece_count = 0;
};

// The same on all ranks. Cubes hold at most some 10^5 centroids of triangles that rounding leaves three
// corners, or eight leaves' if that is more; twice as many where the surface is crowded, and more where it is
// so crowded that seven more levels would not thin it out, or at `most_level`. The counts cost one pass over
// the groups, and another one for each seven levels that a crowd needs. Collective.
BucketPlan plan_buckets(const run::Workspace& workspace, const facts::Catalog& catalog,
                        std::span<const ingest::TriangleGroup> groups, const Rounding& rounding,
                        int most_level);

}  // namespace colossus::pipeline::buckets
