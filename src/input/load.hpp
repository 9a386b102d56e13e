// Whole inputs in memory: for base shapes and for comparisons, never for a build.
#pragma once

#include <span>
#include <string>

#include "input/source.hpp"

namespace colossus::input {

struct LoadedMesh {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint8_t, 4>> colors;  // empty, or one per position: only if all files have them
};

// All files one after the other, as one mesh. Throws like open_source() and Source::read(); Error(kBadData)
// when there is no triangle or there are more than 2^32 - 1 vertices.
LoadedMesh load_mesh(std::span<const std::string> inputs, const SourceOptions& options = {});

}  // namespace colossus::input
