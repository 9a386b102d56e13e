// Where a file name leads when symbolic links are followed, also to what does not exist yet.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <optional>
#include <string>

namespace colossus::core {

// A name in a folder, which is no symbolic link to another name any more.
struct Place {
  std::filesystem::path path;        // as the links spell it
  std::filesystem::path folder;      // of it, without links as far as it exists
  std::string name;                  // in the folder
  std::optional<struct stat> found;  // what is there
  // The name is that of an open descriptor, such as /dev/stdout, /dev/fd/3 or /proc/self/fd/3: it leads to
  // what is open, which may have no name at all.
  bool is_descriptor = false;
  bool is_circle = false;  // links lead to no end

  bool is_folder() const { return found && S_ISDIR(found->st_mode); }
};

// What cannot be looked at counts as missing.
Place place_of(const std::filesystem::path& path);

// Whether they are one file or folder: by device and inode, or where nothing is yet, by folder and name.
bool is_same(const Place& a, const Place& b);

// Whether `inner` lies somewhere below the folder `outer`, which may not exist yet.
bool is_below(const Place& inner, const Place& outer);

// "a folder", "a pipe", "a device", "a socket" or "a regular file".
const char* kind_of(mode_t mode);

std::filesystem::path folder_of(const std::filesystem::path& file);

// Whether the folder of this name is of /proc, whose links are no names of files: they may read
// "pipe:[4711]".
bool is_in_proc(const std::filesystem::path& path);

}  // namespace colossus::core
