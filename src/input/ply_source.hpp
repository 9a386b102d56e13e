// The parts of the PLY reader: what an open file is, and its two sequential readers.
#pragma once

#include <cstdint>

#include "core/file.hpp"
#include "input/ply_header.hpp"
#include "input/ply_rows.hpp"
#include "input/source.hpp"

namespace colossus::input {

struct PlyFile {
  std::uint64_t bytes = 0;
  PlyHeader header;
  VertexLayout vertex_layout;
  ColorProperties face_color = kNoColorProperties;  // of the element face, if the vertices have none
  std::uint64_t vertex_count = 0;
  bool swap = false;  // the byte order of a binary file is not ours
};

// What readers of a part share.
struct PlyReading {
  const PlyFile& ply;
  const core::File& file;
  const SourceInfo& info;
  const SourceOptions& options;
  BlockSink& sink;
};

// The rest of a binary file from element `element` at file offset `offset` on, to the end of the file.
// Vertices only when `with_vertices`. Throws Error(kBadData).
void walk_ply_binary(const PlyReading& reading, std::size_t element, std::uint64_t offset,
                     bool with_vertices);

// Vertices `first` to `first + count` of rows without lists that begin at `offset`, in one block.
VertexBlock read_vertex_rows(const PlyReading& reading, const PlyElement& element, std::uint64_t offset,
                             std::uint64_t first, std::size_t count, Remarks& remarks);

// All of an ASCII file. A row may go on over several lines, but ends where a line does. Throws
// Error(kBadData).
void read_ply_ascii(const PlyReading& reading);

// Throws Error(kBadData): `element` number `row` needs more than what is left of the file.
[[noreturn]] void fail_truncated(const SourceInfo& info, const PlyElement& element, std::uint64_t row,
                                 std::uint64_t offset, std::uint64_t expected, std::uint64_t found);

// Throws Error(kBadData) for a list count below 0.
void check_list_count(const SourceInfo& info, const PlyElement& element, std::uint64_t row,
                      const PlyProperty& list, std::int64_t count);

}  // namespace colossus::input
