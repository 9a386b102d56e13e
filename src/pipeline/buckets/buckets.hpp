// The beginning of the step partition: sends the triangles to the buckets, whose cubes a scheme then works on
// one by one.
#pragma once

#include "pipeline/buckets/bucket_plan.hpp"

namespace colossus::pipeline::buckets {

struct Bucket {
  CubeId cube;
  std::uint64_t triangle_count = 0;
  std::uint64_t vertex_count = 0;          // of all pieces
  std::vector<scratch::RecordRef> pieces;  // in the order of the input's faces
};

struct Buckets {
  BucketTree tree;
  std::vector<Bucket> buckets;  // by their number in the tree; on rank 0
};

struct BucketOptions {
  int most_level = 0;
  // Rank 0 knows 40 bytes of each piece. Where a group would be torn into more pieces than this in total,
  // since the order of its triangles is not that of space, triangles go to runs of buckets first, and from
  // there to buckets: each is written twice, but the pieces are some 100 times fewer.
  std::uint64_t most_pieces = std::uint64_t{1} << 20;
};

// Sends every triangle that has three different corners to all buckets that its bounding box meets, once it
// is rounded: a bucket gets all triangles around any position in its cube. Triangles that lose a corner to
// lattice or rounding are sent too, since they may have a normal, and must not be lost. Counts these, and
// those that had no three corners, in the catalogue, on rank 0. Collective.
Buckets fill_buckets(const run::Workspace& workspace, facts::Catalog& catalog,
                     std::span<const ingest::TriangleGroup> groups, const Rounding& rounding,
                     const BucketOptions& options);

}  // namespace colossus::pipeline::buckets
