// The end of the step lattice: gives every position of the mesh its normal and colour, each in the bucket
// that owns it.
#pragma once

#include "pipeline/buckets/bucket_mesh.hpp"

namespace colossus::pipeline::buckets {

// A bucket's mesh in scratch, and what its neighbours wrote for it.
struct BucketRecord {
  CubeId cube;
  std::uint64_t triangle_count = 0;
  EdgeCensus finest;  // of its mesh
  scratch::RecordRef mesh;
  std::uint64_t lost_count = 0;
  scratch::RecordRef lost;                         // LostTriangle, if there are any
  std::vector<scratch::RecordRef> from_neighbors;  // positions that they own, with attributes
};

// Makes the meshes of all buckets, see BucketMesh, and has them tell each other the attributes of positions
// that triangles share. On rank 0: the buckets that are not empty, the largest first, so that none of them
// starts last. Completes the catalogue's area and its counts of triangles, edges and vertices of the input,
// on all ranks. Throws Error(kNoResources) when a bucket is too crowded for the memory limit, Error(kBadData)
// when the input has no surface to build of. Collective.
std::vector<BucketRecord> give_attributes(const run::Workspace& workspace, facts::Catalog& catalog,
                                          Buckets&& buckets, const Rounding& rounding);

// fill_buckets() and give_attributes(); releases what lies in scratch of the phases before, and with the
// groups their pieces. Throws like these. Collective.
std::vector<BucketRecord> make_buckets(const run::Workspace& workspace, facts::Catalog& catalog,
                                       std::vector<ingest::TriangleGroup>&& groups, const Rounding& rounding,
                                       const BucketOptions& options);

// What became of the input's triangles, its edges, and the colours of its faces.
void log_counts(const cluster::Communicator& ranks, const facts::Catalog& catalog);

// A bucket as a task, and its mesh with all attributes.
core::Bytes bucket_task(const BucketRecord& bucket);
struct LoadedBucket {
  CubeId cube;
  EdgeCensus finest;  // of the mesh
  mesh::Mesh mesh;
  std::vector<LostTriangle> lost;
};
LoadedBucket load_bucket(const run::Workspace& workspace, std::span<const std::byte> task);

}  // namespace colossus::pipeline::buckets
