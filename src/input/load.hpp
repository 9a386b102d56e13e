// Whole inputs in memory: for base shapes and for comparisons, never for a build.
#pragma once

#include <span>
#include <string>

#include "input/source.hpp"

namespace colossus::input {

struct LoadedMesh {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Color> colors;  // empty, or one per position: if a file has some, others are white
};

// All files one after the other, as one mesh. Polygons are triangulated as a build does it: on the lattice
// that fits the vertices that triangles use. Face colours are averaged over the triangles around a vertex.
// What needs a warning is written to stderr. Throws like open_source() and Source::read(); Error(kBadData)
// when there is no triangle, a triangle has a corner that is not finite, or there are more than 2^32 - 1
// vertices.
LoadedMesh load_mesh(std::span<const std::string> inputs, const SourceOptions& options = {});

}  // namespace colossus::input
