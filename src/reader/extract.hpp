// A conforming cut as one indexed mesh, and as a PLY file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "reader/cut.hpp"

namespace colossus::reader {

// Vertices are welded by position across tetrahedra (equal exact positions are bit-equal), in order of first
// occurrence in the cut (rows in order, places ascending); the attributes are those of the first. Triangles
// with two equal positions are dropped, and pairs of triangles with the same corners in opposite order
// cancel, as do those that welding brings together.
struct CutMesh {
  std::vector<std::array<double, 3>> positions;      // world
  std::vector<std::array<std::uint8_t, 2>> normals;  // octahedral codes; empty when the container has none
  std::vector<mesh::Color> colors;                   // empty when the container has none
  std::vector<mesh::Triangle> triangles;
  std::uint64_t stored_triangles = 0;  // before dropping and cancelling
};

// Memory: proportional to the result. Throws like Statue::load(), and Error(kNoResources) for more than 2^31
// - 1 vertices.
CutMesh assemble(const Statue& statue, const Cut& cut);

// Whether floats hold every coordinate exactly, so that they lose nothing of the lattice. Then, and only
// then, a cut is written as floats; and a point has the same value in all cuts.
bool fits_floats(const CutMesh& mesh);

struct ExtractResult {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool has_doubles = false;
};

// Writes PATH.part, binary little-endian, then renames it. Positions are floats or doubles (fits_floats()),
// normals three floats, colours four uchar (red, green, blue, alpha). Throws like assemble(),
// Error(kCannotCreate) when the file cannot be created, kNoResources when the device is full, kIo for other
// failures of writing; PATH.part is then removed.
ExtractResult extract(const Statue& statue, const Cut& cut, const std::filesystem::path& path);

}  // namespace colossus::reader
