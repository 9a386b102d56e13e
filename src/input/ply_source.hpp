// The parts of the PLY reader: what an open file is, and its two sequential readers.
#pragma once

#include <cstdint>

#include "core/file.hpp"
#include "input/ply_header.hpp"
#include "input/ply_rows.hpp"
#include "input/source.hpp"

namespace colossus::input {

struct PlyFile {
  core::File file;
  std::uint64_t bytes = 0;
  PlyHeader header;
  VertexLayout vertex_layout;
  std::uint64_t vertex_count = 0;
  bool swap = false;  // the byte order of a binary file is not ours
};

// The rest of a binary file from element `element` at file offset `offset` on, to the end of the file.
// Vertices only when `with_vertices`. Throws Error(kBadData).
void walk_ply_binary(const PlyFile& ply, const SourceInfo& info, std::size_t element, std::uint64_t offset,
                     bool with_vertices, BlockSink& sink);

// Vertices `first` to `first + count` of rows without lists that begin at `offset`, in one block.
VertexBlock read_vertex_rows(const PlyFile& ply, const SourceInfo& info, const PlyElement& element,
                             std::uint64_t offset, std::uint64_t first, std::size_t count);

// All of an ASCII file. A row may go on over several lines, but ends where a line does. Throws
// Error(kBadData).
void read_ply_ascii(const PlyFile& ply, const SourceInfo& info, BlockSink& sink);

// Throws Error(kBadData): `element` number `row` needs more than what is left of the file.
[[noreturn]] void fail_truncated(const SourceInfo& info, const PlyElement& element, std::uint64_t row,
                                 std::uint64_t offset, std::uint64_t expected, std::uint64_t found);

// Throws Error(kBadData) for a list count below 0.
void check_list_count(const SourceInfo& info, const PlyElement& element, std::uint64_t row,
                      const PlyProperty& list, std::int64_t count);

// Throws Error(kBadData) unless only white space is left.
void check_file_end(const PlyFile& ply, const SourceInfo& info, std::uint64_t offset);

}  // namespace colossus::input
