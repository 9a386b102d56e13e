// The join, of the steps extent and lattice: puts the vertices onto the lattice, and gives each group of
// triangles those that it uses, without ever holding all of them.
//
// The join goes through scratch, in two steps. Vertices are numbered over all files and divided into ranges.
// First each group of triangles writes, for each range, the sorted numbers that it uses ("requests").
// Then each range is loaded once and answers all groups ("answers"). Triangles in an order that has nothing
// to do with that of the vertices cost more and smaller records, but no more memory.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "pipeline/ingest/piece.hpp"

namespace colossus::pipeline::ingest {

// The vertices of one range that a group uses.
struct VertexSlice {
  std::uint32_t range = 0;
  std::uint32_t count = 0;
  scratch::RecordRef record;  // the request, then the answer
};

// Consecutive input blocks of triangles, and all their vertices.
struct TriangleGroup {
  std::uint64_t triangle_count = 0;
  std::uint64_t polygon_count = 0;
  scratch::RecordRef triangles;  // indices into the vertices of the slices, one after the other; see join.cpp
  std::vector<VertexSlice> slices;
};

// A group has at least so many triangles, if there are, and less than an input block more; a range has so
// many vertices. Neither depends on the ranks or on memory.
std::uint64_t group_size(const facts::Catalog& catalog);
std::uint64_t range_size(const facts::Catalog& catalog);

// First step: the groups with their requests. They are in the order of the input's faces, on rank 0 only: 32
// bytes for each group and range that it uses. Some 100 MB at most on any rank. Collective.
std::vector<TriangleGroup> request_vertices(const run::Workspace& workspace, const facts::Catalog& catalog);

// Second step, once the lattice is set: requests become answers. Collective.
void answer_requests(const run::Workspace& workspace, const facts::Catalog& catalog,
                     std::vector<TriangleGroup>& groups);

// Then, where the input has polygons: their fans are replaced by what their corners on the lattice want, see
// input::PolygonCutter. Completes the catalogue's counts of polygons. Collective.
void cut_polygons(const run::Workspace& workspace, facts::Catalog& catalog,
                  std::vector<TriangleGroup>& groups);

// The ranges that groups ask for, each as a task of a phase between the steps: on rank 0.
class RequestedRanges {
 public:
  RequestedRanges(const facts::Catalog& catalog, const std::vector<TriangleGroup>& groups);
  std::size_t size() const { return ranges_.size(); }
  core::Bytes task(std::size_t i) const;
  // The slices of task i, in its order.
  std::vector<VertexSlice*> slices(std::size_t i, std::vector<TriangleGroup>& groups) const;

 private:
  struct Asker {
    std::uint32_t group;
    std::uint32_t slice;
  };
  const std::vector<TriangleGroup>& groups_;
  std::vector<std::uint64_t> ranges_;
  std::vector<std::vector<Asker>> askers_;  // by task
};

// Calls visit(number, position) for the vertices that the groups of such a task use, ascending by number over
// all files. Not collective.
void visit_requested(const run::Workspace& workspace, const facts::Catalog& catalog,
                     std::span<const std::byte> task,
                     const std::function<void(std::uint64_t, const std::array<double, 3>&)>& visit);

// Of a group as a task.
core::Bytes group_task(const TriangleGroup& group);
// All its triangles; vertices ascend by number. Where faces have colours, each corner of a triangle becomes a
// vertex of its own with the face's colour, behind the others, with a number from kFaceCornerNumbers on. Not
// collective.
Piece load_group(const run::Workspace& workspace, const facts::Catalog& catalog,
                 std::span<const std::byte> task);

}  // namespace colossus::pipeline::ingest
