// What a user asks of a build. Each member but `command` is a line in option_table.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "codec/codec.hpp"
#include "codec/coded/weights.hpp"

namespace colossus::pipeline::facts {

struct BuildOptions {
  std::vector<std::string> inputs;  // files, or @list.txt
  std::filesystem::path output;
  std::optional<std::filesystem::path> scratch;  // else <output>.scratch
  bool resume = false;  // continue what an interrupted build has left in scratch, if anything
  // Since the start of the program, after which the build stops; see core::parse_duration().
  std::optional<std::string> time_limit;
  std::string scheme;                   // empty: the first in pipeline/schemes.cpp
  std::uint64_t leaf_triangles = 8000;  // per tetrahedron, after clipping; on average per cube
  int position_bits = codec::coded::kDefaultPositionBits;
  std::optional<double> tolerance;  // world units; chooses position_bits
  bool drop_textures = false;
  bool is_lenient = false;     // see input::SourceOptions
  bool keep_outliers = false;  // go on although a far corner makes the lattice coarser than the triangles
  std::optional<std::string> memory;                 // per rank, see parse_size(); else a share of the host's
  std::optional<std::filesystem::path> status_file;  // see schemas/
  std::optional<std::filesystem::path> report_file;
  bool is_dry_run = false;           // ends after the estimate
  std::vector<std::string> command;  // the words of the command line, for the report
  std::string codec = codec::codecs().front().name;
  // Of blocks alone.
  std::optional<int> levels;      // the deepest level, instead of the one that leaf_triangles gives
  std::optional<int> block_size;  // cubes along a block
  double color_weight = 0.0;      // of colours in the error of a collapse, see simplify::Region
  // False: the borders of all levels lie on top of each other. For tests/bench/clefts, which shows what
  // shifting is for; no option of the program, and not known to readers.
  bool has_shifted_blocks = true;
};

// Inner nodes keep at least this many triangles per non-empty tetrahedron: strict halving would let nodes
// shrink by a fifth per level, since a surface fills only some 1.6 of the 2 halves of a tetrahedron
// (src/README.md).
inline std::uint64_t floor_triangles(const BuildOptions& options) { return options.leaf_triangles / 4; }

}  // namespace colossus::pipeline::facts
