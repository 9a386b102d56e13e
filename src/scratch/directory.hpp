// The directory of a build's scratch files: in it one folder, which holds a manifest, and what each rank of
// each attempt has written.
//
// The folder is called by the latest attempt: attempt-0003. A later attempt takes over by renaming it, which
// is atomic: of two that want to, one succeeds. Ranks of an earlier attempt that still live can then neither
// create, open nor delete anything by its name; what they go on writing to open files lies behind what
// counts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scratch/record.hpp"

namespace colossus::scratch {

// What the scratch files of a build belong to: all that shapes their content, as names and values for people.
// The text is one line per entry and a checksum. Its hash is the key of all records.
struct Manifest {
  std::vector<std::pair<std::string, std::string>> entries;  // of one line each

  void add(const std::string& name, const std::string& value);
  std::string text() const;
  std::uint64_t key() const;
  // Nothing for a text that is torn, damaged or not one of ours.
  static std::optional<Manifest> parse(const std::string& text);
  // What differs, for a message: "leaf_triangles is 8000 there, and 1500 here"; empty for equal ones.
  std::string difference_from(const Manifest& there) const;
  friend bool operator==(const Manifest&, const Manifest&) = default;
};

// What lies in the folder of an attempt.
struct FolderContent {
  bool has_manifest = false;  // a file of that name, whatever is in it
  bool has_foreign = false;   // files that are not ours
  std::vector<FileId> files;  // ascending
};
FolderContent look_into(const std::filesystem::path& folder);

// How long all files in it are together; what cannot be read counts nothing.
std::uint64_t bytes_in(const std::filesystem::path& folder);

// What lies in a scratch directory.
struct DirectoryContent {
  bool exists = false;
  bool is_empty = false;      // a directory, and nothing in it
  bool is_lent = false;       // was there before the build, and is to stay
  bool has_foreign = false;   // anything but folders of attempts, and the note that it is lent
  std::uint16_t attempt = 0;  // the latest; 0 when there is none
};
DirectoryContent look_into_directory(const std::filesystem::path& directory);

// attempt-0003 in the directory.
std::filesystem::path folder_of_attempt(const std::filesystem::path& directory, std::uint16_t attempt);

// Creates the directory, whose parent must exist, and in it the folder of attempt 1. False when there is
// something of this name already: of two builds that want the same directory, one gets it. Throws
// Error(kNoResources), Error(kIo) or Error(kCannotCreate), and leaves nothing then.
bool create_scratch_directory(const std::filesystem::path& directory);

// Uses a directory that exists and is empty, as create_scratch_directory() uses its own: it is noted that it
// is lent, so that it stays when scratch is removed. False when somebody else has just begun to use it.
bool use_empty_directory(const std::filesystem::path& directory);

// Makes the folder of the attempt after `latest` out of that of `latest`, or a new one if that is 0, and
// returns its number. Throws Error(kCannotCreate) when another build was faster; Error(kNoResources) or
// Error(kIo).
std::uint16_t take_attempt(const std::filesystem::path& directory, std::uint16_t latest);

// Creates the manifest, which must not exist. Throws like core::File.
void write_manifest(const std::filesystem::path& folder, const Manifest& manifest);
// Nothing when there is none, or it is torn or damaged. Throws Error(kIo) when it cannot be read.
std::optional<Manifest> read_manifest(const std::filesystem::path& folder);
void remove_manifest(const std::filesystem::path& folder);

// Deletes files; those that are not there are none. Throws Error(kIo).
void remove_files(const std::filesystem::path& folder, const std::vector<FileId>& files);

// Deletes the folder of the attempt with all our files, the manifest last, and the directory unless it is
// lent. Does nothing when a later attempt has taken over. Throws Error(kIo) when something cannot be removed,
// or a file that is not ours lies in it, which stays.
void remove_scratch_directory(const std::filesystem::path& directory, std::uint16_t attempt);

}  // namespace colossus::scratch
