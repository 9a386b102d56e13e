// What the ranks know about the input once it has been read: where its blocks lie in scratch, and counts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/lattice.hpp"
#include "input/source.hpp"
#include "scratch/spool.hpp"

namespace colossus::build {

// Kinds of scratch records.
enum class RecordKind : std::uint32_t {
  kRawVertices = 1,     // as read: doubles
  kTriangles = 2,       // indices within the file
  kGroupTriangles = 3,  // indices into the group's vertices
  kRequest = 4,         // offsets within a range of vertices
  kAnswer = 5,          // the same offsets, and the vertices there
  kMesh = 6,            // a SampledMesh
  kChunk = 7,           // a frame of the container
  kRim = 8,             // positions of the vertices that a cube shares
  kPiece = 9,           // a Piece: triangles of one bucket
  kAttributes = 10,     // mesh::Vertex, for a neighbour
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
  std::uint64_t split_edges = 0;  // too long for their cubes (blocks)
  // Of the vertices that triangles with three corners use: those at a position that another one has, and
  // positions whose vertices had different attributes, which were averaged.
  std::uint64_t merged_vertices = 0;
  std::uint64_t attribute_seams = 0;
};

struct Catalog {
  std::vector<InputFile> files;
  std::vector<VertexBlockRef> vertex_blocks;      // ascending
  std::vector<TriangleBlockRef> triangle_blocks;  // in the order of the files' faces
  geometry::Bounds bounds;
  geometry::Lattice lattice;
  InputCounts counts;
  // Vertices that a block of triangles has, roughly, summed over the blocks: about half as many as triangles where
  // their order is that of space, and up to three times as many. On rank 0.
  std::uint64_t block_vertices = 0;
  bool has_normals = false;  // at least one file has them; the others' are computed
  bool has_colors = false;
};

}  // namespace colossus::build
