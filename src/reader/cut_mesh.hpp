// The surface of a cut of any scheme as one indexed mesh, and as a PLY file.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/outputs.hpp"
#include "mesh/mesh.hpp"

namespace colossus::reader {

struct CutMesh {
  std::vector<std::array<double, 3>> positions;      // world
  std::vector<std::array<std::uint8_t, 2>> normals;  // octahedral codes; empty when the container has none
  std::vector<mesh::Color> colors;                   // empty when the container has none
  std::vector<mesh::Triangle> triangles;
  std::uint64_t stored_triangles = 0;  // before dropping

  // Appends a position and returns its index; the attributes are left to the caller. Throws
  // Error(kNoResources) for more than 2^31 - 1 vertices.
  std::uint32_t add_position(const std::array<double, 3>& world);
};

// Welds vertices by their world positions, bit by bit: the first one's attributes stay. Equal exact positions
// have equal world positions; where the origin is so far away that different ones have as well, an
// independent program would weld them, so we do. Drops triangles with two equal positions, and vertices that
// no triangle uses any more. Two opposite triangles with the same corners are surface, a plate without
// thickness, and stay.
void weld(CutMesh& mesh);

// Whether floats hold every coordinate exactly, so that they lose nothing of the lattice. Then, and only
// then, a cut is written as floats; and a point has the same value in all cuts.
bool fits_floats(const CutMesh& mesh);

struct ExtractResult {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool has_doubles = false;
};

// Writes it, binary little-endian, as core::OutputFile does. Positions are floats or doubles (fits_floats()),
// normals three floats, colours four uchar (red, green, blue, alpha). Throws Error(kCannotCreate) when the
// file cannot be created, kNoResources when the device is full, kIo for other failures of writing; no part of
// a file is left then.
ExtractResult write(const CutMesh& mesh, const core::OutputTarget& target);

}  // namespace colossus::reader
