// Outputs spare what is there: before anything is written, all names that a command will write are compared
// with its inputs and with each other.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace colossus::core {

// What must stay as it is.
struct SparedFile {
  std::string role;  // for messages, e.g. "the input"
  std::filesystem::path path;
};

enum class OutputKind {
  kFile,          // a regular file, written as PATH.part and renamed when it is complete
  kFileOrStream,  // likewise; but a device, a pipe, or what /dev/stdout is, is written to and stays
  kFolder,        // with all that will lie in it
};

// The name of a file while it is written.
inline constexpr const char* kPartEnding = ".part";
inline std::filesystem::path part_of(std::filesystem::path path) { return path += kPartEnding; }

struct OutputRequest {
  std::string option;  // for messages, e.g. "--report"
  std::filesystem::path path;
  OutputKind kind = OutputKind::kFile;
  std::size_t inner_bytes = 0;  // of a folder: the longest path in it
};

// Where an output is really written: symbolic links are followed.
struct OutputTarget {
  OutputTarget() = default;
  OutputTarget(std::filesystem::path file) : path(std::move(file)) {}  // NOLINT: implicit on purpose
  std::filesystem::path path;
  bool is_stream = false;  // opened as it is, written from front to back, never replaced or removed
  int descriptor = -1;     // of a stream that this process has been given open, else -1

  bool is_asked_for() const { return !path.empty(); }
  // Whether what is written to the descriptor would come into the same file.
  bool is_same_as(int other_descriptor) const;
};

// Looks at all names, and touches nothing. Returns one target for each request. Throws
// - Error(kUsage) for an output that is something spared or another output (device and inode; for what does
//   not exist yet, folder and name; PATH.part counts), that lies in a folder which is an output, or in which
//   something spared lies; for a device, pipe or socket where a regular file is needed; for an empty name;
// - Error(kCannotCreate) for a folder in the place of a file and the reverse, a name that is too long, links
//   that lead in a circle, and a folder that is not there or cannot be written.
// Cost: linear in the spared files, for each request.
std::vector<OutputTarget> plan_outputs(std::span<const SparedFile> spared,
                                       std::span<const OutputRequest> requests);

}  // namespace colossus::core
