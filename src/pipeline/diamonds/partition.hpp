// The step partition: cuts the triangles exactly into the leaf tetrahedra of a conforming diamond hierarchy.
#pragma once

#include <unordered_set>

#include "pipeline/diamonds/tetrahedron_mesh.hpp"
#include "pipeline/ingest/join.hpp"

namespace colossus::pipeline::diamonds {

using DiamondSet = std::unordered_set<hierarchy::Point, geometry::PointHash>;

struct Partition {
  DiamondSet splits;  // closed under parents; the same on all ranks
  std::vector<TetrahedronRecord>
      leaves;                     // on rank 0: the non-empty leaf tetrahedra, ordered by level, centre, place
  std::uint64_t revived = 0;      // on rank 0: pairs of triangles that stand for what the lattice took
  std::uint32_t first_phase = 0;  // in whose scratch the leaves lie
  std::uint32_t last_phase = 0;
};

// Collective. First the triangles go to buckets, the cubes of a coarse octree made from exact counts of
// centroids; then each bucket's triangles are cut by the planes from the root on, duplicates dropped, and
// tetrahedra bisected while they hold more than --leaf-triangles and a bisection helps; then diamonds are
// completed until the hierarchy conforms. A tetrahedron above the limit stays a leaf when its larger half
// would keep more than nine tenths of its triangles, and halves together more than 1.05 times as many: a
// split that merely moves all into one half is followed further, so that a far outlier does not leave the
// statue in one leaf. It also stays when the cuts on the way to it have made more than eight pieces of each
// triangle, as happens to bundles of long slivers. Fills the catalogue's area and counts.
Partition partition(const run::Workspace& workspace, facts::Catalog& catalog,
                    std::vector<ingest::TriangleGroup>&& groups);

}  // namespace colossus::pipeline::diamonds
