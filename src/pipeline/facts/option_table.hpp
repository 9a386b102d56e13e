// The table of all options of a build. Command line, manifest, container, report and their tests follow it,
// so that a new option is a member of BuildOptions and one line here.
#pragma once

#include <string>
#include <vector>

#include "container/schema.hpp"
#include "hierarchy/octree.hpp"
#include "pipeline/facts/options.hpp"
#include "pipeline/facts/stored.hpp"

namespace colossus::pipeline::facts {

// Other commands that read meshes have this option, too.
inline constexpr const char* kLenientHelp =
    "Let pass, and say so: floats for indices and counts, surplus numbers in a row, prose in headers, other "
    "bytes behind the data";

struct Option {
  const char* name;  // in manifest, container and report; see flag_of() for the command line
  const char* help;  // nullptr: tests and benchmarks have it, the program has not
  // Of what shapes bytes:
  Stored stored = Stored::kNever;
  const char* scheme = nullptr;  // the only one that has it; nullptr: all have it
};

// Each of these calls visit(option, pointer to the member of BuildOptions) in the order of --help.

// What is read and written. The manifest says of inputs what they are on the disk.
template <typename Visit>
constexpr void for_each_file_option(Visit visit) {
  using O = BuildOptions;
  visit(Option{"inputs", "PLY, OBJ, STL or OFF files, or @list.txt; together one statue"}, &O::inputs);
  visit(Option{"output", "The container to write, e.g. statue.h5"}, &O::output);
}

// What shapes the container's bytes, and so is in the manifest and in the report; within the options of one
// scheme, and of all, in the order of the container's table.
template <typename Visit>
constexpr void for_each_shaping_option(Visit visit) {
  using O = BuildOptions;
  constexpr const char* kBlocks = hierarchy::kBlocks;
  visit(Option{"scheme", "The shape of nodes"}, &O::scheme);
  visit(
      Option{"leaf_triangles",
             "Most triangles per leaf tetrahedron; of blocks: most on average per cube of the deepest level",
             Stored::kAlways},
      &O::leaf_triangles);
  visit(Option{"position_bits",
               "Bits per barycentric weight, 8 to 16; of blocks: along a cube of the deepest level",
               Stored::kAlways},
        &O::position_bits);
  visit(Option{"codec", "How nodes are stored", Stored::kAlways}, &O::codec);
  visit(Option{"tolerance",
               "Largest quantisation error of the finest level in the input's units; chooses the bits",
               Stored::kUnlessDefault},
        &O::tolerance);
  visit(Option{"block_size", "cubes along a block; default: 4", Stored::kUnlessDefault, kBlocks},
        &O::block_size);
  visit(Option{"levels", "the deepest level, instead of the one that fits", Stored::kUnlessDefault, kBlocks},
        &O::levels);
  visit(Option{"color_weight", "mean edge lengths that a full change of colour counts when simplifying",
               Stored::kUnlessDefault, kBlocks},
        &O::color_weight);
  visit(Option{"shifted_blocks", nullptr, Stored::kNever, kBlocks}, &O::has_shifted_blocks);
  visit(
      Option{"keep_outliers", "Go on although a few far corners make the lattice coarser than the triangles",
             Stored::kUnlessDefault},
      &O::keep_outliers);
  visit(Option{"drop_textures", "Accept texture coordinates and materials, and drop them",
               Stored::kUnlessDefault},
        &O::drop_textures);
  visit(Option{"lenient", kLenientHelp, Stored::kUnlessDefault}, &O::is_lenient);
}

// How the build is run, which may be another way in each attempt.
template <typename Visit>
constexpr void for_each_run_option(Visit visit) {
  using O = BuildOptions;
  visit(Option{"memory",
               "Most memory per rank, e.g. 512M or 2G, at least 256M; default: its share of the host's"},
        &O::memory);
  visit(Option{"dry_run", "Read the input, tell what the build will need, and end"}, &O::is_dry_run);
  visit(Option{"status", "Keep how far the build is in this file, a small JSON"}, &O::status_file);
  visit(Option{"report", "Write what was done, how long it took and what it used to this file, a JSON"},
        &O::report_file);
  visit(Option{"scratch", "Folder for temporary files, to be created, or empty; default: <output>.scratch"},
        &O::scratch);
  visit(Option{"resume", "Continue the build that was interrupted; without one, begin a new one"},
        &O::resume);
  visit(Option{"time_limit",
               "Stop in order after this time, e.g. 90s, 45m, 3h50m, 1-02:00:00; then see --resume"},
        &O::time_limit);
}

template <typename Visit>
constexpr void for_each_option(Visit visit) {
  for_each_file_option(visit);
  for_each_shaping_option(visit);
  for_each_run_option(visit);
}

// The value of an option, or nullptr where it is not given.
template <typename T>
const T* given(const std::optional<T>& value) {
  return value ? &*value : nullptr;
}
template <typename T>
const T* given(const T& value) {
  return &value;
}

// "--leaf-triangles" of "leaf_triangles".
std::string flag_of(const Option& option);

// All that shape bytes and are given, for the manifest.
std::vector<container::NamedText> shaping_options(const BuildOptions& options);

// Those that a container stores: of all schemes if `scheme` is nullptr, else of that one alone. `chosen`
// holds what the build has chosen where the user has not.
std::vector<container::NamedText> stored_options(const BuildOptions& chosen, const char* scheme);

// Throws Error(kUsage) when an option is given that the scheme has not.
void refuse_options_of_other_schemes(const BuildOptions& options);

}  // namespace colossus::pipeline::facts
