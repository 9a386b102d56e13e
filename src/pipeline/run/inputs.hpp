// What tells whether a build is still the same one: its inputs as they lie on the disk, and its options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/outputs.hpp"
#include "pipeline/facts/options.hpp"
#include "scratch/directory.hpp"

namespace colossus::pipeline::run {

// All files of the arguments, and the lists among them, for outputs to spare. Throws Error(kBadData) for a
// list that cannot be read, and like core::check_input_name().
std::vector<core::SparedFile> spared_inputs(std::span<const std::string> arguments);

struct InputStamp {
  std::filesystem::path path;  // absolute
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;  // nanoseconds since 1970
};

// All inputs, lists expanded. Throws Error(kBadData) when one is not there, or is no regular file.
std::vector<InputStamp> stamps_of_inputs(const facts::BuildOptions& options);

// Throws Error(kBadData) that names the file, unless the inputs are as they were.
void check_unchanged(const std::vector<InputStamp>& before);

// All that shapes the content of scratch files: the program, down to its sources, options, inputs.
scratch::Manifest manifest_of(const facts::BuildOptions& options, const std::vector<InputStamp>& inputs);

}  // namespace colossus::pipeline::run
