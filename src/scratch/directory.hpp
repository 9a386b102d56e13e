// The directory of a build's scratch files.
#pragma once

#include <cstdint>
#include <filesystem>

namespace colossus::scratch {

// One rank creates the directory, the others open it; the caller has all ranks wait in between, and before it
// is removed. The object of the rank that created the directory removes it, with the spool files in it, on
// destruction too: a build that fails leaves nothing behind. Files that are not ours are never removed.
class ScratchDirectory {
 public:
  // Throws Error(kCannotCreate) when `path` exists already, since another build may be using it, or when it
  // cannot be created; Error(kNoResources) when the disk is full. Parent directories must exist.
  static ScratchDirectory create(const std::filesystem::path& path);
  // Throws Error(kIo) when there is no such directory: this host does not see what another one created.
  static ScratchDirectory open(const std::filesystem::path& path);

  ScratchDirectory(ScratchDirectory&& other) noexcept;
  ScratchDirectory& operator=(ScratchDirectory&&) = delete;
  ScratchDirectory(const ScratchDirectory&) = delete;
  // Warns when the directory cannot be removed.
  ~ScratchDirectory();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path spool_path(std::uint32_t rank) const { return spool_path(path_, rank); }
  static std::filesystem::path spool_path(const std::filesystem::path& directory, std::uint32_t rank);

  // Removes the directory now; for the rank that created it. Throws Error(kIo) when something cannot be
  // removed, or a file that is not ours lies in it.
  void remove();
  // The destructor leaves the directory.
  void keep() { is_owner_ = false; }

 private:
  ScratchDirectory(std::filesystem::path path, bool is_owner);

  std::filesystem::path path_;
  bool is_owner_ = false;
};

}  // namespace colossus::scratch
