// What the ranks know about the input once it has been read: where its input blocks lie in scratch, and
// counts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/lattice.hpp"
#include "input/source.hpp"
#include "scratch/spool.hpp"

namespace colossus::pipeline::facts {

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
  kLost = 11,           // LostTriangle
};

// Before positions, normals and colours in a record of raw vertices.
struct RawVerticesHeader {
  std::uint32_t has_normals = 0;
  std::uint32_t color_readings = 0;  // 0: no colours; 1; 2: see input::ReadColor
};

// Before triangles, input::Polygon and face colours in a record of triangles.
struct RawTrianglesHeader {
  std::uint32_t polygons = 0;
  std::uint32_t color_readings = 0;
};

// An input block of vertices in scratch: consecutive ones of all files, numbered through.
struct VertexBlockRef {
  std::uint32_t file = 0;
  std::uint32_t count = 0;
  std::uint64_t first =
      0;  // number of the first vertex; within the file until the survey is complete, then over all
  scratch::RecordRef record;
};

// An input block of triangles in scratch.
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
  bool has_colors = false;  // of vertices or faces
};

// Each member is a line in count_table.hpp.
struct InputCounts {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;  // as read, polygons cut into triangles
  std::uint64_t polygons = 0;   // faces with more than three corners
  // Of these, see input::OddPolygons:
  std::uint64_t concave_polygons = 0;
  std::uint64_t warped_polygons = 0;
  std::uint64_t crossing_polygons = 0;
  std::uint64_t small_faces = 0;  // faces with fewer than three corners, skipped
  std::uint64_t degenerate = 0;   // two equal corners; dropped
  std::uint64_t collapsed = 0;    // that have two equal corners on the lattice, or the grid of blocks, only
  std::uint64_t duplicate = 0;    // the corners of an earlier one; dropped
  std::uint64_t opposite = 0;     // the corners of an earlier one, turned over; dropped
  std::uint64_t collinear = 0;    // three corners on one line
  // Of what is left of the input:
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
  std::uint64_t inconsistent_edges = 0;  // two triangles run along it in the same direction
  // Of the finest level as it is stored:
  std::uint64_t leaves_above_limit = 0;
  std::uint64_t finest_triangles = 0;
  std::uint64_t finest_border_edges = 0;
  std::uint64_t finest_nonmanifold_edges = 0;
  std::uint64_t area_differs = 0;  // 1: from the input's, see nodes::AreaCheck
  std::uint64_t split_edges = 0;   // too long for their cubes (blocks)
  // Of the vertices that triangles with three corners use: those at a position that another one has, and
  // positions whose vertices had different attributes, which were averaged.
  std::uint64_t merged_vertices = 0;
  std::uint64_t attribute_seams = 0;
  std::uint64_t color_seams = 0;  // of these, with different colours
};

// The corner farthest from the middle of the input, where it and a few others alone make the lattice coarse.
struct FarCorner {
  bool is_far = false;
  std::uint32_t file = 0;
  std::uint64_t vertex = 0;  // of the file
  std::array<double, 3> position{};
  geometry::Bounds core;     // of the nearest 99.9 % of the vertices
  double median_edge = 0.0;  // of the input on its lattice; world units
};

struct Catalog {
  std::vector<InputFile> files;
  std::vector<input::ColorScale> color_scales;    // by file
  std::vector<VertexBlockRef> vertex_blocks;      // ascending
  std::vector<TriangleBlockRef> triangle_blocks;  // in the order of the files' faces
  geometry::Bounds bounds;                        // of the vertices that triangles use
  FarCorner far_corner;
  geometry::Lattice lattice;
  // On the lattice, of what is left of the input; in square lattice units, so that it cannot overflow.
  double area = 0.0;
  InputCounts counts;
  // Vertices that an input block of triangles has, roughly, summed over these blocks: about half as many as
  // triangles where their order is that of space, and up to three times as many. On rank 0.
  std::uint64_t input_block_vertices = 0;
  bool has_normals = false;  // at least one file has them; the others' are computed
  bool has_colors = false;   // at least one file has them; the others become white
  bool has_face_colors = false;
  bool has_both_readings = false;  // of colours, in scratch

  // For messages.
  std::string input_name() const { return files.size() == 1 ? files[0].name : "all inputs"; }
};

}  // namespace colossus::pipeline::facts
