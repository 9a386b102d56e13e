// A mesh as a PLY file.
#pragma once

#include <cstdint>

#include "core/outputs.hpp"
#include "reader/access/cut_mesh.hpp"

namespace colossus::exporters {

// Whether floats hold every coordinate exactly, so that they lose nothing of the lattice. Then, and only
// then, a cut is written as floats; and a point has the same value in all cuts.
bool fits_floats(const reader::access::CutMesh& mesh);

struct WrittenPly {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool has_doubles = false;
};

// Writes it, binary little-endian, as core::OutputFile does. Positions are floats or doubles (fits_floats()),
// normals three floats, colours four uchar (red, green, blue, alpha). Throws Error(kCannotCreate) when the
// file cannot be created, kNoResources when the device is full, kIo for other failures of writing; no part of
// a file is left then.
WrittenPly write_ply(const reader::access::CutMesh& mesh, const core::OutputTarget& target);

}  // namespace colossus::exporters
