// Phase 2: puts the vertices onto the lattice, and gives each group of triangles those that it uses, without
// ever holding all of them.
//
// The join goes through scratch, in two steps. Vertices are numbered over all files and divided into ranges.
// First each group of triangle blocks writes, for each range, the sorted numbers that it uses ("requests").
// Then each range is loaded once and answers all groups ("answers"). Triangles in an order that has nothing
// to do with that of the vertices cost more and smaller records, but no more memory.
#pragma once

#include <span>
#include <vector>

#include "build/piece.hpp"

namespace colossus::build {

// The vertices of one range that a group uses.
struct VertexSlice {
  std::uint32_t range = 0;
  std::uint32_t count = 0;
  scratch::RecordRef record;  // the request, then the answer
};

// Consecutive blocks of triangles, and all their vertices.
struct TriangleGroup {
  std::uint64_t triangle_count = 0;
  scratch::RecordRef triangles;  // indices into the vertices of the slices, one after the other
  std::vector<VertexSlice> slices;
};

// Joins the triangles of the catalogue, whose lattice is set, to their vertices. The groups are in the order
// of the input's faces, on rank 0 only: 32 bytes for each group and range that it uses. Neither groups nor
// ranges depend on the ranks or on memory. Some 100 MB at most on any rank. Collective.
std::vector<TriangleGroup> join_vertices(const Workspace& workspace, const Catalog& catalog);

// Of a group as a task.
core::Bytes group_task(const TriangleGroup& group);
// All its triangles; vertices ascend by number. Not collective.
Piece load_group(const Workspace& workspace, const Catalog& catalog, std::span<const std::byte> task);

}  // namespace colossus::build
