#include "scratch/directory.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <system_error>

#include "core/error.hpp"
#include "core/hash.hpp"

namespace colossus::scratch {
namespace {

constexpr const char* kManifestName = "manifest";
constexpr const char* kLentName = "keep-this-folder";  // an empty file
constexpr const char* kFirstLine = "Colossus scratch files, format 2\n";
constexpr const char* kChecksumName = "checksum";

// 0 for any other name.
std::uint16_t attempt_of_name(const std::string& name) {
  unsigned attempt = 0;
  if (std::sscanf(name.c_str(), "attempt-%u", &attempt) != 1) return 0;
  if (attempt > std::numeric_limits<std::uint16_t>::max()) return 0;
  const auto number = static_cast<std::uint16_t>(attempt);
  return folder_of_attempt({}, number) == name ? number : std::uint16_t{0};
}

std::uint64_t hash_of(const std::string& text) {
  return core::hash64(std::as_bytes(std::span(text.data(), text.size())));
}

std::string lines_of(const Manifest& manifest) {
  std::string text = kFirstLine;
  for (const auto& [name, value] : manifest.entries) text += fmt::format("{}: {}\n", name, value);
  return text;
}

[[noreturn]] void fail_removal(const std::filesystem::path& path, const std::string& reason) {
  core::fail(core::Status::kIo, "{}: cannot remove: {}: remove the scratch directory by hand", path.string(),
             reason);
}

// What is not there is removed already.
void remove_folder(const std::filesystem::path& path) {
  if (::rmdir(path.c_str()) != 0 && errno != ENOENT) fail_removal(path, std::strerror(errno));
}

void remove_file(const std::filesystem::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail_removal(path, std::strerror(errno));
}

}  // namespace

// Paths may hold line ends.
void Manifest::add(const std::string& name, const std::string& value) {
  std::string line;
  for (const char c : value) line += c == '\n' ? "\\n" : c == '\\' ? "\\\\" : std::string(1, c);
  entries.emplace_back(name, line);
}

std::string Manifest::text() const {
  const std::string lines = lines_of(*this);
  return lines + fmt::format("{}: {:016x}\n", kChecksumName, hash_of(lines));
}

std::uint64_t Manifest::key() const { return hash_of(lines_of(*this)); }

std::optional<Manifest> Manifest::parse(const std::string& text) {
  Manifest manifest;
  std::string lines = kFirstLine;
  if (!text.starts_with(lines)) return std::nullopt;
  for (std::size_t at = lines.size(); at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const std::size_t colon = text.find(": ", at);
    if (end == std::string::npos || colon >= end) return std::nullopt;
    const std::string name = text.substr(at, colon - at);
    std::string value = text.substr(colon + 2, end - colon - 2);
    if (name == kChecksumName) {
      const bool is_whole = end + 1 == text.size() && value == fmt::format("{:016x}", hash_of(lines));
      return is_whole ? std::optional(manifest) : std::nullopt;
    }
    lines += text.substr(at, end + 1 - at);
    manifest.entries.emplace_back(name, std::move(value));
    at = end + 1;
  }
  return std::nullopt;
}

std::string Manifest::difference_from(const Manifest& there) const {
  constexpr const char* kAbsent = "absent";
  const auto value_in = [](const Manifest& manifest, const std::string& name) {
    const auto found = std::find_if(manifest.entries.begin(), manifest.entries.end(),
                                    [&](const auto& entry) { return entry.first == name; });
    return found == manifest.entries.end() ? std::string(kAbsent) : found->second;
  };
  std::string text;
  const auto compare = [&](const std::string& name) {
    const std::string mine = value_in(*this, name);
    const std::string other = value_in(there, name);
    if (mine == other) return;
    text += fmt::format("{}{} is {} there, and {} here", text.empty() ? "" : "; ", name, other, mine);
  };
  for (const auto& entry : entries) compare(entry.first);
  for (const auto& entry : there.entries)
    if (value_in(*this, entry.first) == kAbsent) compare(entry.first);
  return text;
}

FolderContent look_into(const std::filesystem::path& folder) {
  FolderContent content;
  try {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name == kManifestName)
        content.has_manifest = true;
      else if (const auto file = file_of_name(name))
        content.files.push_back(*file);
      else
        content.has_foreign = true;
    }
  } catch (const std::filesystem::filesystem_error& error) {
    core::fail(core::Status::kIo, "{}: cannot read the scratch directory: {}", folder.string(),
               error.code().message());
  }
  std::sort(content.files.begin(), content.files.end());
  return content;
}

std::uint64_t bytes_in(const std::filesystem::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code unreadable;
    const std::uintmax_t size = at->file_size(unreadable);
    if (!unreadable) bytes += size;
  }
  return bytes;
}

DirectoryContent look_into_directory(const std::filesystem::path& directory) {
  DirectoryContent content;
  try {
    content.exists = std::filesystem::exists(std::filesystem::symlink_status(directory));
    if (!content.exists) return content;
    content.is_empty = true;
    for (const auto& entry : std::filesystem::directory_iterator(directory)) {
      content.is_empty = false;
      const std::string name = entry.path().filename().string();
      const std::uint16_t attempt = attempt_of_name(name);
      if (name == kLentName)
        content.is_lent = true;
      else
        content.has_foreign |= attempt == 0;
      content.attempt = std::max(content.attempt, attempt);
    }
  } catch (const std::filesystem::filesystem_error& error) {
    core::fail(core::Status::kIo, "{}: cannot read the scratch directory: {}", directory.string(),
               error.code().message());
  }
  return content;
}

std::filesystem::path folder_of_attempt(const std::filesystem::path& directory, std::uint16_t attempt) {
  return directory / fmt::format("attempt-{:04}", attempt);
}

bool create_scratch_directory(const std::filesystem::path& directory) {
  // mkdir() is atomic.
  if (::mkdir(directory.c_str(), 0777) == 0) {
    try {
      take_attempt(directory, 0);
    } catch (const core::Error&) {
      ::rmdir(directory.c_str());
      throw;
    }
    return true;
  }
  if (errno == EEXIST) return false;
  core::fail(core::create_status(errno), "{}: cannot create the scratch directory: {}", directory.string(),
             std::strerror(errno));
}

// The note comes first, so that a build that is killed in between does not lose it; who has made it goes on.
// Should somebody who has just created the directory make the folder of the attempt at the same time, mkdir()
// decides.
bool use_empty_directory(const std::filesystem::path& directory) {
  const std::filesystem::path note = directory / kLentName;
  try {
    core::File::create(note, true).close();
  } catch (const core::Error&) {
    if (look_into_directory(directory).is_empty) throw;
    return false;
  }
  try {
    take_attempt(directory, 0);
  } catch (const core::Error&) {
    ::unlink(note.c_str());
    throw;
  }
  return true;
}

std::uint16_t take_attempt(const std::filesystem::path& directory, std::uint16_t latest) {
  if (latest == std::numeric_limits<std::uint16_t>::max())
    core::fail(core::Status::kCannotCreate, "{}: too many attempts: remove the scratch directory",
               directory.string());
  const auto attempt = static_cast<std::uint16_t>(latest + 1);
  const std::filesystem::path folder = folder_of_attempt(directory, attempt);
  const int failed = latest == 0 ? ::mkdir(folder.c_str(), 0777)
                                 : ::rename(folder_of_attempt(directory, latest).c_str(), folder.c_str());
  if (failed == 0) return attempt;
  if (errno == EEXIST || errno == ENOTEMPTY || errno == ENOENT)
    core::fail(core::Status::kCannotCreate, "{}: another build has just begun to use the scratch directory",
               directory.string());
  core::fail(core::create_status(errno), "{}: cannot create: {}", folder.string(), std::strerror(errno));
}

void write_manifest(const std::filesystem::path& folder, const Manifest& manifest) {
  core::File file = core::File::create(folder / kManifestName, true);
  const std::string text = manifest.text();
  file.write_at(0, std::as_bytes(std::span(text.data(), text.size())));
  file.close();
}

std::optional<Manifest> read_manifest(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kManifestName;
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const core::Bytes bytes = core::read_file(path);
    return Manifest::parse({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  } catch (const core::Error& error) {
    throw core::Error(core::Status::kIo, fmt::format("scratch file {}", error.what()));
  }
}

void remove_manifest(const std::filesystem::path& folder) { remove_file(folder / kManifestName); }

void remove_files(const std::filesystem::path& folder, const std::vector<FileId>& files) {
  for (const FileId& file : files) remove_file(path_of(folder, file));
}

void remove_scratch_directory(const std::filesystem::path& directory, std::uint16_t attempt) {
  const std::filesystem::path folder = folder_of_attempt(directory, attempt);
  if (!std::filesystem::exists(folder)) return;
  remove_files(folder, look_into(folder).files);
  remove_manifest(folder);
  remove_folder(folder);
  if (look_into_directory(directory).is_lent)
    remove_file(directory / kLentName);
  else
    remove_folder(directory);
}

}  // namespace colossus::scratch
