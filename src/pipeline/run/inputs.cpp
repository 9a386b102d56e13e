#include "pipeline/run/inputs.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "core/error.hpp"
#include "core/file.hpp"
#include "core/place.hpp"
#include "core/version.hpp"
#include "input/source.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/run/build_id.hpp"

namespace colossus::pipeline::run {
namespace {

InputStamp stamp_of(const std::filesystem::path& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0)
    core::fail(core::Status::kBadData, "{}: cannot open: {}", path.string(), std::strerror(errno));
  if (!S_ISREG(info.st_mode))
    core::fail(core::Status::kBadData, "{}: is {}; expected a regular file", path.string(),
               core::kind_of(info.st_mode));
  return {std::filesystem::absolute(path), static_cast<std::uint64_t>(info.st_size),
          std::int64_t{info.st_mtim.tv_sec} * 1'000'000'000 + info.st_mtim.tv_nsec};
}

std::string describe(const InputStamp& stamp) {
  return fmt::format("{} bytes modified at {}.{:09} s", stamp.bytes, stamp.modified / 1'000'000'000,
                     stamp.modified % 1'000'000'000);
}

}  // namespace

std::vector<core::SparedFile> spared_inputs(std::span<const std::string> arguments) {
  std::vector<core::SparedFile> spared;
  const auto add = [&](const char* role, const std::filesystem::path& path) {
    core::check_input_name(path);
    spared.push_back({role, path});
  };
  for (const std::filesystem::path& list : input::lists_of(arguments)) add("the list", list);
  for (const std::filesystem::path& path : input::expand_inputs(arguments)) add("the input", path);
  return spared;
}

std::vector<InputStamp> stamps_of_inputs(const facts::BuildOptions& options) {
  std::vector<InputStamp> stamps;
  for (const auto& path : input::expand_inputs(options.inputs)) stamps.push_back(stamp_of(path));
  return stamps;
}

void check_unchanged(const std::vector<InputStamp>& before) {
  for (const InputStamp& stamp : before) {
    const InputStamp now = stamp_of(stamp.path);
    if (now.bytes == stamp.bytes && now.modified == stamp.modified) continue;
    core::fail(core::Status::kBadData,
               "{}: was changed while it was read: expected {}, found {}: run again when it is complete",
               stamp.path.string(), describe(stamp), describe(now));
  }
}

scratch::Manifest manifest_of(const facts::BuildOptions& options, const std::vector<InputStamp>& inputs) {
  scratch::Manifest manifest;
  manifest.add("program", core::release_version());
  manifest.add("build", build_id());
  for (const container::NamedText& option : shaping_options(options)) manifest.add(option.name, option.value);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    manifest.add(fmt::format("input {}", i + 1),
                 fmt::format("{}, {}", inputs[i].path.string(), describe(inputs[i])));
  return manifest;
}

}  // namespace colossus::pipeline::run
