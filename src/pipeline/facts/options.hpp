// What a user asks of a build. Each member but `command` and `of_scheme` is a line in option_table.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "codec/codec.hpp"
#include "codec/coded/weights.hpp"
#include "pipeline/facts/scheme_options.hpp"

namespace colossus::pipeline::facts {

struct BuildOptions {
  std::vector<std::string> inputs;  // files, or @list.txt
  std::filesystem::path output;
  std::optional<std::filesystem::path> scratch;  // else <output>.scratch
  bool resume = false;  // continue what an interrupted build has left in scratch, if anything
  // Since the start of the program, after which the build stops; see core::parse_duration().
  std::optional<std::string> time_limit;
  std::string scheme;                   // empty: the first in pipeline/schemes.cpp
  std::uint64_t leaf_triangles = 8000;  // of a leaf, as the scheme counts
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
  SchemeValues of_scheme;  // options that the scheme alone has, as they were given
};

// Inner nodes keep at least this many triangles per non-empty tetrahedron: strict halving would let nodes
// shrink by a fifth per level, since a surface fills only some 1.6 of the 2 halves of a tetrahedron
// (src/README.md).
inline std::uint64_t floor_triangles(const BuildOptions& options) { return options.leaf_triangles / 4; }

}  // namespace colossus::pipeline::facts
