#include "core/place.hpp"

#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <system_error>

namespace colossus::core {
namespace {

constexpr int kMostLinks = 40;  // as Linux itself

std::filesystem::path without_slashes_at_the_end(const std::filesystem::path& path) {
  std::string text = path.string();
  while (text.size() > 1 && text.back() == '/') text.pop_back();
  return text;
}

bool is_same_inode(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

bool is_same_folder(const std::filesystem::path& a, const std::filesystem::path& b) {
  struct stat at_a {};
  struct stat at_b {};
  const bool has_a = ::stat(a.c_str(), &at_a) == 0;
  const bool has_b = ::stat(b.c_str(), &at_b) == 0;
  if (has_a != has_b) return false;
  return has_a ? is_same_inode(at_a, at_b) : a == b;
}

// Absolute, without links as far as it exists and may be looked at.
std::filesystem::path without_links(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::absolute(path, error);
  std::filesystem::path result = std::filesystem::weakly_canonical(absolute, error);
  return error ? absolute.lexically_normal() : result;
}

// Sets folder and name. Of a path that ends with ".." or has no name, the folder itself is the place.
void locate(Place& place) {
  const std::filesystem::path name = place.path.filename();
  const bool has_name = !name.empty() && name != "." && name != "..";
  const std::filesystem::path whole =
      has_name ? without_links(folder_of(place.path)) / name : without_links(place.path);
  place.folder = whole.parent_path();
  place.name = whole.filename().string();
}

}  // namespace

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  return S_ISSOCK(mode) ? "a socket" : "a regular file";
}

bool is_in_proc(const std::filesystem::path& path) {
  struct statfs info {};
  return ::statfs(folder_of(path).c_str(), &info) == 0 && info.f_type == PROC_SUPER_MAGIC;
}

Place place_of(const std::filesystem::path& path) {
  Place place;
  place.path = without_slashes_at_the_end(path);
  struct stat info {};
  for (int links = 0; ::lstat(place.path.c_str(), &info) == 0 && S_ISLNK(info.st_mode); ++links) {
    place.is_descriptor = is_in_proc(place.path);
    place.is_circle = links == kMostLinks;
    if (place.is_descriptor || place.is_circle) break;
    std::error_code error;
    const std::filesystem::path target = std::filesystem::read_symlink(place.path, error);
    if (error || target.empty()) break;
    // An absolute target replaces the folder.
    place.path = without_slashes_at_the_end(
        target.is_absolute() || !place.path.has_parent_path() ? target : place.path.parent_path() / target);
  }
  if (::stat(place.path.c_str(), &info) == 0) place.found = info;
  locate(place);
  return place;
}

bool is_same(const Place& a, const Place& b) {
  if (a.found && b.found) return is_same_inode(*a.found, *b.found);
  return a.name == b.name && is_same_folder(a.folder, b.folder);
}

bool is_below(const Place& inner, const Place& outer) {
  if (inner.found && !outer.found) return false;
  const std::filesystem::path root = outer.folder / outer.name;
  for (std::filesystem::path at = inner.folder;; at = at.parent_path()) {
    if (is_same_folder(at, root)) return true;
    if (!at.has_relative_path()) return false;
  }
}

}  // namespace colossus::core
