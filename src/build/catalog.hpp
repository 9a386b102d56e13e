// What the ranks know about the input once it has been read: where its blocks lie in scratch, and counts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/lattice.hpp"
#include "geometry/point.hpp"
#include "input/source.hpp"
#include "mesh/mesh.hpp"
#include "scratch/mapped_spool.hpp"
#include "scratch/spool.hpp"

namespace colossus::build {

// Kinds of scratch records.
enum class RecordKind : std::uint32_t {
  kRawVertices = 1,    // as read: doubles
  kTriangles = 2,      // indices within the file
  kVertices = 3,       // mesh::Vertex, on the lattice
  kFinalVertices = 4,  // the same with all normals, equal attributes at equal positions
  kBucket = 5,         // BucketTriangle
  kMesh = 6,           // a SampledMesh
  kChunk = 7,          // a frame of the container
  kRim = 8,            // positions of the vertices that a cube shares
};

// Consecutive vertices of all files, numbered through.
struct VertexBlockRef {
  std::uint32_t file = 0;
  std::uint32_t count = 0;
  std::uint64_t first =
      0;  // number of the first vertex; within the file until the survey is complete, then over all
  scratch::RecordRef record;
};

struct TriangleBlockRef {
  std::uint32_t file = 0;
  std::uint32_t count = 0;
  std::uint64_t first_vertex = 0;  // of the file, over all files: added to the indices of the block
  scratch::RecordRef record;
};

struct InputFile {
  std::string name;  // without folders
  std::uint64_t bytes = 0;
  std::string hash;
  bool has_normals = false;
  bool has_colors = false;
};

struct InputCounts {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;    // as read, polygons as fans
  std::uint64_t polygons = 0;     // faces with more than three corners
  std::uint64_t small_faces = 0;  // faces with fewer than three corners, skipped
  std::uint64_t degenerate = 0;   // dropped
  std::uint64_t duplicate = 0;    // dropped
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
  std::uint64_t split_edges = 0;      // too long for their cubes (blocks)
  std::uint64_t merged_vertices = 0;  // vertices at a position that an earlier one has
  std::uint64_t attribute_seams =
      0;  // positions whose vertices had different attributes, which were averaged
};

struct Catalog {
  std::vector<InputFile> files;
  std::vector<VertexBlockRef> vertex_blocks;      // ascending
  std::vector<TriangleBlockRef> triangle_blocks;  // in the order of the files' faces
  geometry::Bounds bounds;
  geometry::Lattice lattice;
  InputCounts counts;
  bool has_normals = false;  // at least one file has them; the others' are computed
  bool has_colors = false;
};

// Random access to the vertices of all files through mapped scratch records.
class VertexStore {
 public:
  VertexStore(const std::vector<VertexBlockRef>& blocks, scratch::MappedSpool& spool) : blocks_(&blocks) {
    for (const VertexBlockRef& block : blocks) spans_.push_back(spool.map_array<mesh::Vertex>(block.record));
  }
  const mesh::Vertex& operator[](std::uint64_t vertex) const {
    const VertexBlockRef& hint = (*blocks_)[block_];
    if (vertex - hint.first >= hint.count) block_ = find(vertex);
    return spans_[block_][vertex - (*blocks_)[block_].first];
  }
  // Number of the block that holds a vertex.
  std::size_t find(std::uint64_t vertex) const {
    const auto after =
        std::upper_bound(blocks_->begin(), blocks_->end(), vertex,
                         [](std::uint64_t v, const VertexBlockRef& block) { return v < block.first; });
    return static_cast<std::size_t>(after - blocks_->begin()) - 1;
  }
  std::span<const mesh::Vertex> block(std::size_t index) const { return spans_[index]; }

 private:
  const std::vector<VertexBlockRef>* blocks_;
  std::vector<std::span<const mesh::Vertex>> spans_;
  mutable std::size_t block_ = 0;
};

}  // namespace colossus::build
