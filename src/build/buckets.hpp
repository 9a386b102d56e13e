// The coarse octree whose cubes collect triangles before they are cut.
#pragma once

#include "build/catalog.hpp"
#include "build/workspace.hpp"

namespace colossus::build {

// A cube of side 2^(30 - depth) at index (x, y, z).
struct Cube {
  std::int32_t depth = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  bool contains(const geometry::Point& p) const {
    const int shift = geometry::kRootBits - depth;
    return p.x >> shift == x && p.y >> shift == y && p.z >> shift == z;
  }
};

// A triangle on its way to the buckets; vertices are numbered over all files.
using BucketTriangle = std::array<std::uint64_t, 3>;

struct Bucket {
  Cube cube;
  std::vector<scratch::RecordRef>
      records;  // on rank 0: arrays of BucketTriangle, in the order of the input's faces
  std::uint64_t triangle_count = 0;
};

// The buckets that are not empty, as tasks: the largest first, so that none of them starts last. On rank 0.
std::vector<std::size_t> filled_buckets(const std::vector<Bucket>& buckets);
core::Bytes bucket_task(const Bucket& bucket);
Bucket bucket_of_task(std::span<const std::byte> task);  // without the count

// Sends every triangle that is not degenerate to all buckets that its bounding box meets; counts the
// degenerate ones in the catalogue. The buckets are the same on all ranks but for their records. None is
// deeper than `most_depth`. Collective.
std::vector<Bucket> fill_buckets(const Workspace& workspace, Catalog& catalog, int most_depth);

}  // namespace colossus::build
