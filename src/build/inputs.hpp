// What tells whether a build is still the same one: its inputs as they lie on the disk, and its options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "build/options.hpp"
#include "scratch/directory.hpp"

namespace colossus::build {

struct InputStamp {
  std::filesystem::path path;  // absolute
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  // nanoseconds since 1970
};

// All inputs, lists expanded. Throws Error(kBadData) when one is not there.
std::vector<InputStamp> stamps_of_inputs(const BuildOptions& options);

// Throws Error(kBadData) that names the file, unless the inputs are as they were.
void check_unchanged(const std::vector<InputStamp>& before);

// All that shapes the content of scratch files: program, options, inputs.
scratch::Manifest manifest_of(const BuildOptions& options, const std::vector<InputStamp>& inputs);

}  // namespace colossus::build
