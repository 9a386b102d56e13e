#include "scratch/directory.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/file.hpp"
#include "core/log.hpp"

namespace colossus::scratch {
namespace {

constexpr std::string_view kSpoolPrefix = "rank-";
constexpr std::string_view kSpoolSuffix = ".spool";

bool is_spool_name(const std::string& name) {
  if (!name.starts_with(kSpoolPrefix) || !name.ends_with(kSpoolSuffix)) return false;
  const std::size_t digits = name.size() - kSpoolPrefix.size() - kSpoolSuffix.size();
  const std::string number = name.substr(kSpoolPrefix.size(), digits);
  return !number.empty() &&
         std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

ScratchDirectory::ScratchDirectory(std::filesystem::path path, bool is_owner)
    : path_(std::move(path)), is_owner_(is_owner) {}

ScratchDirectory::ScratchDirectory(ScratchDirectory&& other) noexcept
    : path_(std::move(other.path_)), is_owner_(std::exchange(other.is_owner_, false)) {}

ScratchDirectory::~ScratchDirectory() {
  if (!is_owner_) return;
  try {
    remove();
  } catch (const std::exception& error) {
    core::warn_line(error.what());
  }
}

ScratchDirectory ScratchDirectory::create(const std::filesystem::path& path) {
  // mkdir() is atomic: of two builds that want the same directory, one gets it.
  if (::mkdir(path.c_str(), 0777) != 0) {
    if (errno == EEXIST)
      core::fail(core::Status::kCannotCreate,
                 "{}: the scratch directory exists already: another build is using it, or was killed; remove "
                 "it if no "
                 "build is running",
                 path.string());
    const core::Status status = core::write_status(errno);
    core::fail(status == core::Status::kIo ? core::Status::kCannotCreate : status,
               "{}: cannot create the scratch directory: {}", path.string(), std::strerror(errno));
  }
  return {path, true};
}

ScratchDirectory ScratchDirectory::open(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error))
    core::fail(
        core::Status::kIo,
        "{}: this rank does not see the scratch directory: it must be on a file system that all hosts share",
        path.string());
  return {path, false};
}

std::filesystem::path ScratchDirectory::spool_path(const std::filesystem::path& directory,
                                                   std::uint32_t rank) {
  return directory / fmt::format("{}{:06}{}", kSpoolPrefix, rank, kSpoolSuffix);
}

void ScratchDirectory::remove() {
  COLOSSUS_CHECK(is_owner_, "{}", path_.string());
  is_owner_ = false;
  try {
    std::vector<std::filesystem::path> spools;
    for (const auto& entry : std::filesystem::directory_iterator(path_))
      if (is_spool_name(entry.path().filename().string())) spools.push_back(entry.path());
    for (const auto& spool : spools) std::filesystem::remove(spool);
    std::filesystem::remove(path_);
  } catch (const std::filesystem::filesystem_error& error) {
    core::fail(core::Status::kIo, "{}: cannot remove the scratch directory: {}: remove it by hand",
               path_.string(), error.code().message());
  }
}

}  // namespace colossus::scratch
