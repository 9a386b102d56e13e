#include "core/outputs.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <climits>
#include <cstring>
#include <utility>

#include "core/error.hpp"
#include "core/place.hpp"

namespace colossus::core {
namespace {

// A name that is read or written, and whose it is.
struct Name {
  std::string text;  // for messages
  Place place;
  std::size_t owner = 0;  // one for each spared file and each request
  bool is_output = false;
  bool is_folder = false;  // all below it is its own
};

std::string full_name(const OutputRequest& request) { return request.option + " " + request.path.string(); }

bool is_stream(const OutputRequest& request, const Place& place) {
  if (request.kind != OutputKind::kFileOrStream) return false;
  if (place.is_descriptor) return true;
  return place.found &&
         (S_ISFIFO(place.found->st_mode) || S_ISCHR(place.found->st_mode) || S_ISBLK(place.found->st_mode));
}

// The number of an open descriptor of this process that was there when it started; else -1.
int own_descriptor(const Place& place) {
  int number = -1;
  const auto [end, error] = std::from_chars(place.name.data(), place.name.data() + place.name.size(), number);
  if (error != std::errc() || end != place.name.data() + place.name.size()) return -1;
  struct stat own {};
  struct stat folder {};
  if (::stat("/proc/self/fd", &own) != 0 || ::stat(place.folder.c_str(), &folder) != 0) return -1;
  if (own.st_dev != folder.st_dev || own.st_ino != folder.st_ino) return -1;
  // What is not to be inherited was not: it is a file of this program's, or of MPI's.
  const int flags = ::fcntl(number, F_GETFD);
  return flags >= 0 && (flags & FD_CLOEXEC) == 0 ? number : -1;
}

void check_conflict(const Name& a, const Name& b) {
  if (a.owner == b.owner || !(a.is_output || b.is_output)) return;
  const bool is_one = is_same(a.place, b.place);
  const bool is_in_a = a.is_folder && is_below(b.place, a.place);
  const bool is_in_b = b.is_folder && is_below(a.place, b.place);
  if (!is_one && !is_in_a && !is_in_b) return;
  const Name& first = a.is_output ? a : b;
  const Name& second = a.is_output ? b : a;
  fail(Status::kUsage, "{} {} {}: nothing was written; choose another name", first.text,
       is_one                      ? "is the same as"
       : (&first == &a) == is_in_a ? "is a folder that contains"
                                   : "lies in the folder of",
       second.text);
}

void check_folder(const OutputRequest& request, const Place& place) {
  const std::filesystem::path folder = folder_of(place.path);
  struct stat info {};
  if (::stat(folder.c_str(), &info) != 0 && errno != ENOENT)
    fail(Status::kCannotCreate, "{}: cannot look into the folder {}: {}", full_name(request), folder.string(),
         std::strerror(errno));
  if (!S_ISDIR(info.st_mode))
    fail(Status::kCannotCreate, "{}: the folder {} does not exist", full_name(request), folder.string());
  if (is_in_proc(place.path))
    fail(Status::kCannotCreate, "{}: cannot create: the folder {} holds no files", full_name(request),
         folder.string());
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    fail(Status::kCannotCreate, "{}: the folder {} cannot be written: {}", full_name(request),
         folder.string(), std::strerror(errno));
}

void check_length(const OutputRequest& request, const Place& place, std::size_t more_in_name,
                  std::size_t more_in_path) {
  const auto limit_of = [&](int name, std::size_t otherwise) {
    const long limit = ::pathconf(folder_of(place.path).c_str(), name);
    return limit > 0 ? static_cast<std::size_t>(limit) : otherwise;
  };
  const std::size_t name_limit = limit_of(_PC_NAME_MAX, NAME_MAX);
  if (place.name.size() + more_in_name > name_limit)
    fail(Status::kCannotCreate, "{}: the name is too long: {} bytes, with what is added to it {}; at most {}",
         full_name(request), place.name.size(), place.name.size() + more_in_name, name_limit);
  // The limit counts the zero at the end.
  const std::size_t path_limit = limit_of(_PC_PATH_MAX, PATH_MAX) - 1;
  const std::size_t path_bytes = place.path.string().size() + more_in_name + more_in_path;
  if (path_bytes > path_limit)
    fail(Status::kCannotCreate, "{}: the path is too long: with what is added to it {} bytes; at most {}",
         full_name(request), path_bytes, path_limit);
}

void check_stream(const OutputRequest& request, const Place& place, int descriptor) {
  const bool is_writable = descriptor >= 0 ? (::fcntl(descriptor, F_GETFL) & O_ACCMODE) != O_RDONLY
                                           : place.found && ::access(place.path.c_str(), W_OK) == 0;
  if (!is_writable || place.is_folder())
    fail(Status::kCannotCreate, "{}: is not open for writing", full_name(request));
}

// Of what is there: a regular file may be replaced, a folder may be used.
void check_kind(const OutputRequest& request, const std::string& text, const Place& place) {
  const bool needs_folder = request.kind == OutputKind::kFolder;
  if (!place.found) return;
  const mode_t mode = place.found->st_mode;
  const char* expected = needs_folder ? "a folder" : "a regular file";
  if (place.is_descriptor || !(S_ISREG(mode) || S_ISDIR(mode)))
    fail(Status::kUsage, "{}: is {}, which is never replaced; expected {}", text,
         place.is_descriptor ? "an open descriptor" : kind_of(mode), expected);
  if (S_ISDIR(mode) != needs_folder)
    fail(Status::kCannotCreate, "{}: cannot create: it is {}; expected {}", text, kind_of(mode), expected);
}

OutputTarget target_of(const OutputRequest& request, const Place& place) {
  if (place.is_circle)
    fail(Status::kCannotCreate, "{}: cannot create: its symbolic links lead in a circle", full_name(request));
  OutputTarget target(place.path);
  target.is_stream = is_stream(request, place);
  if (target.is_stream) {
    if (place.is_descriptor) target.descriptor = own_descriptor(place);
    check_stream(request, place, target.descriptor);
    return target;
  }
  check_kind(request, full_name(request), place);
  if (request.kind == OutputKind::kFolder && place.found) {
    if (::access(place.path.c_str(), R_OK | W_OK | X_OK) != 0)
      fail(Status::kCannotCreate, "{}: the folder cannot be used: {}", full_name(request),
           std::strerror(errno));
  } else {
    check_folder(request, place);
  }
  if (request.kind == OutputKind::kFolder) {
    check_length(request, place, 0, 1 + request.inner_bytes);
    return target;
  }
  check_length(request, place, std::strlen(kPartEnding), 0);
  check_kind(request, full_name(request) + kPartEnding, place_of(part_of(place.path)));
  return target;
}

}  // namespace

bool OutputTarget::is_same_as(int other_descriptor) const {
  struct stat mine {};
  struct stat other {};
  return ::stat(path.c_str(), &mine) == 0 && ::fstat(other_descriptor, &other) == 0 &&
         mine.st_dev == other.st_dev && mine.st_ino == other.st_ino;
}

std::vector<OutputTarget> plan_outputs(std::span<const SparedFile> spared,
                                       std::span<const OutputRequest> requests) {
  std::vector<Name> names;
  for (const SparedFile& file : spared)
    names.push_back({file.role + " " + file.path.string(), place_of(file.path), names.size(), false, false});
  std::vector<Place> places;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const OutputRequest& request = requests[i];
    if (request.path.empty()) fail(Status::kUsage, "{}: expected a name, found an empty one", request.option);
    const Place& place = places.emplace_back(place_of(request.path));
    const bool is_folder = request.kind == OutputKind::kFolder;
    const std::size_t owner = spared.size() + i;
    names.push_back({full_name(request), place, owner, true, is_folder});
    if (is_folder || is_stream(request, place)) continue;
    const std::filesystem::path part = part_of(place.path);
    names.push_back(
        {fmt::format("{} (the name of {} while it is written)", part.string(), full_name(request)),
         place_of(part), owner, true, false});
  }
  // Inputs are not compared with each other: there may be very many.
  for (std::size_t j = spared.size(); j < names.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) check_conflict(names[i], names[j]);
  std::vector<OutputTarget> targets;
  for (std::size_t i = 0; i < requests.size(); ++i) targets.push_back(target_of(requests[i], places[i]));
  return targets;
}

}  // namespace colossus::core
