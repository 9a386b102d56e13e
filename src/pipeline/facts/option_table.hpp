// The table of the options that builds of all schemes have; scheme_options.hpp is about the others. Command
// line, manifest, container, report and their tests follow it, so that a new option is a member of BuildOptions and one line here.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "container/schema.hpp"
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
};

// Each of these calls visit(option, pointer to the member of BuildOptions) in the order of --help.

// What is read and written. The manifest says of inputs what they are on the disk.
template <typename Visit>
constexpr void for_each_file_option(Visit visit) {
  using O = BuildOptions;
  visit(Option{"inputs", "files, or @list.txt; together one statue"}, &O::inputs);
  visit(Option{"output", "The container to write, e.g. statue.h5"}, &O::output);
}

// What shapes the container's bytes, and so is in the manifest and in the report; in the order of the
// container's table, which the options of the scheme follow.
template <typename Visit>
constexpr void for_each_shaping_option(Visit visit) {
  using O = BuildOptions;
  visit(Option{"scheme", "The shape of nodes"}, &O::scheme);
  visit(Option{"leaf_triangles", "Most triangles", Stored::kAlways}, &O::leaf_triangles);
  visit(Option{"position_bits", "Bits of a position, 8 to 16", Stored::kAlways}, &O::position_bits);
  visit(Option{"codec", "How nodes are stored", Stored::kAlways}, &O::codec);
  visit(Option{"tolerance",
               "Largest quantisation error of the finest level in the input's units; chooses the bits",
               Stored::kUnlessDefault},
        &O::tolerance);
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
std::string flag_of(std::string_view name);

// All that shape bytes and are given, those of the scheme too, for the manifest.
std::vector<container::NamedText> shaping_options(const BuildOptions& options);

// Those of all schemes that a container stores. `chosen` holds what the build has chosen where the user has
// not.
std::vector<container::NamedText> stored_options(const BuildOptions& chosen);

}  // namespace colossus::pipeline::facts
