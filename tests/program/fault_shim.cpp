// A library to be preloaded into the colossus program: lets one of its file operations fail, come short, or
// be the moment at which a signal is sent. Moments are thus counted in progress, never in time.
//
// From the environment:
//   COLOSSUS_SHIM_FOLDERS  paths, separated by colons: operations on files whose path begins with one of them
//   count COLOSSUS_SHIM_STATE    a file of 4096 zeros, shared by all ranks: the count, and the ranks' process
//   ids COLOSSUS_SHIM_TRACE    optional: a file to which a line "operation name kind phase" is appended for
//   each one COLOSSUS_SHIM_FAULT    optional: "event n when action target"
//     event   "any", or "PHASE.KIND" of a record in a journal, as in the trace, or an operation, or "part"
//     for writes to
//             a container
//     n       the fault is in the n-th such event of all ranks together, from 1
//     when    "before", "half" (of the bytes are written) or "after" the operation
//     action  "short" (no error), an errno, a signal as "-9", or "late": the clocks of all ranks jump by a
//     day target  of a signal: "self", "parent", "ranks", "all" (ranks and parent), or a number: one of the
//     ranks
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <sstream>
#include <string>
#include <vector>

namespace {

constexpr std::size_t kMostRanks = 64;
constexpr std::size_t kMostDescriptors = 1024;
constexpr std::size_t kRecordHeaderBytes = 24;

struct State {
  std::atomic<std::uint32_t> events;
  std::atomic<std::uint32_t> ranks;
  std::atomic<std::uint32_t> is_late;
  std::array<std::atomic<std::int32_t>, kMostRanks> pids;
};

struct Fault {
  std::string event, when, action, target;
  std::uint32_t n = 0;
};

struct Operation {
  const char* name;
  std::string file;    // without folders
  std::string kind;    // of a record in a journal, or "-"
  unsigned phase = 0;  // of a task's record
};

template <typename Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

class Shim {
 public:
  Shim() {
    std::istringstream folders(environment("COLOSSUS_SHIM_FOLDERS"));
    for (std::string folder; std::getline(folders, folder, ':');) folders_.push_back(folder);
    std::istringstream fault(environment("COLOSSUS_SHIM_FAULT"));
    fault >> fault_.event >> fault_.n >> fault_.when >> fault_.action >> fault_.target;
    const std::string state = environment("COLOSSUS_SHIM_STATE");
    const int descriptor = real<int (*)(const char*, int, ...)>("open")(state.c_str(), O_RDWR | O_CLOEXEC);
    void* const memory = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (memory == MAP_FAILED) std::abort();
    state_ = static_cast<State*>(memory);
    state_->pids.at(state_->ranks++) = ::getpid();
    const std::string trace = environment("COLOSSUS_SHIM_TRACE");
    if (!trace.empty())
      trace_ = real<int (*)(const char*, int, ...)>("open")(trace.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  }

  bool watches(const char* path) const {
    for (const std::string& folder : folders_)
      if (std::strncmp(path, folder.c_str(), folder.size()) == 0) return true;
    return false;
  }

  void note_open(int descriptor, const char* path) {
    if (descriptor >= 0 && static_cast<std::size_t>(descriptor) < kMostDescriptors)
      paths_[static_cast<std::size_t>(descriptor)] = path;
  }
  std::string path_of(int descriptor) const {
    return descriptor >= 0 && static_cast<std::size_t>(descriptor) < kMostDescriptors
               ? paths_[static_cast<std::size_t>(descriptor)]
               : std::string();
  }

  // Whether the fault is in this operation. Traces it.
  bool meets(const Operation& operation) {
    if (trace_ >= 0) {
      std::ostringstream line;
      line << operation.name << ' ' << operation.file << ' ' << operation.kind << ' ' << operation.phase
           << '\n';
      const std::string text = line.str();
      if (real<ssize_t (*)(int, const void*, std::size_t)>("write")(trace_, text.data(), text.size()) < 0)
        std::abort();
    }
    if (!is_event(operation)) return false;
    return ++state_->events == fault_.n;
  }

  const Fault& fault() const { return fault_; }
  bool is_error() const {
    return !fault_.action.empty() && fault_.action[0] >= '0' && fault_.action[0] <= '9';
  }
  bool is_short() const { return fault_.action == "short"; }
  int error() const { return std::atoi(fault_.action.c_str()); }

  bool is_late() const { return state_->is_late != 0; }

  void send() const {
    if (fault_.action == "late") {
      state_->is_late = 1;
      return;
    }
    const int signal = -std::atoi(fault_.action.c_str());
    const auto count = std::min<std::size_t>(state_->ranks, kMostRanks);
    if (fault_.target == "parent" || fault_.target == "all") ::kill(::getppid(), signal);
    if (fault_.target == "ranks" || fault_.target == "all") {
      for (std::size_t i = 0; i < count; ++i)
        if (state_->pids[i] != ::getpid()) ::kill(state_->pids[i], signal);
      ::kill(::getpid(), signal);
    } else if (fault_.target == "self") {
      ::kill(::getpid(), signal);
    } else if (fault_.target != "parent") {
      ::kill(state_->pids[static_cast<std::size_t>(std::atoi(fault_.target.c_str())) % count], signal);
    }
  }

  int failing_descriptor = -1;  // its next write fails: the rest of one that came short

 private:
  bool is_event(const Operation& operation) const {
    if (fault_.n == 0) return false;
    if (fault_.event == "any") return true;
    if (fault_.event == "part")
      return operation.file.ends_with(".part") && std::strcmp(operation.name, "pwrite") == 0;
    if (fault_.event == operation.name) return true;
    return fault_.event == std::to_string(operation.phase) + "." + operation.kind;
  }

  std::vector<std::string> folders_;
  Fault fault_;
  State* state_ = nullptr;
  int trace_ = -1;
  std::array<std::string, kMostDescriptors> paths_;
};

Shim& shim() {
  static Shim* const instance = new Shim;  // never destroyed: others write until the very end
  return *instance;
}

// So that a rank is known before it does anything.
const bool is_ready = (shim(), true);

std::string file_of(const std::string& path) { return path.substr(path.rfind('/') + 1); }

Operation write_operation(const std::string& path, const void* bytes, std::size_t size) {
  Operation operation{"pwrite", file_of(path), "-", 0};
  if (!path.ends_with(".journal") || size < kRecordHeaderBytes + 4) return operation;
  std::array<std::uint32_t, 2> header{};
  std::memcpy(header.data(), bytes, sizeof header);
  constexpr std::array<const char*, 5> kKinds{"-", "start", "task", "release", "recall"};
  if (header[1] >= kKinds.size()) return operation;
  operation.kind = kKinds[header[1]];
  if (operation.kind == "task")
    std::memcpy(&operation.phase, static_cast<const char*>(bytes) + kRecordHeaderBytes,
                sizeof operation.phase);
  return operation;
}

// Does an operation that returns 0 or -1, with what the fault makes of it.
template <typename Do>
int act(const Operation& operation, const Do& operate) {
  if (!shim().meets(operation) || shim().is_short()) return operate();
  if (shim().is_error()) {
    errno = shim().error();
    return -1;
  }
  if (shim().fault().when != "after") shim().send();
  const int result = operate();
  if (shim().fault().when == "after") shim().send();
  return result;
}

template <typename Write>
ssize_t act_on_write(int descriptor, const void* bytes, std::size_t size, const Write& write) {
  const std::string path = shim().path_of(descriptor);
  if (path.empty()) return write(size);
  if (shim().failing_descriptor == descriptor) {
    shim().failing_descriptor = -1;
    errno = shim().error();
    return -1;
  }
  if (!shim().meets(write_operation(path, bytes, size))) return write(size);
  const bool is_half = shim().fault().when == "half" || shim().is_short();
  const std::size_t part = size > 1 ? size / 2 : size;
  if (shim().is_short()) return write(part);
  if (shim().is_error()) {
    if (is_half) {
      shim().failing_descriptor = descriptor;
      return write(part);
    }
    errno = shim().error();
    return -1;
  }
  if (shim().fault().when == "before") shim().send();
  const ssize_t result = write(is_half ? part : size);
  if (shim().fault().when != "before") shim().send();
  return result;
}

int open_file(const char* name, const char* path, int flags, mode_t mode) {
  const auto open = [&] { return real<int (*)(const char*, int, ...)>(name)(path, flags, mode); };
  const bool is_of_interest =
      (flags & O_ACCMODE) != O_RDONLY || (flags & O_DIRECTORY) != 0;  // these are flushed
  if (!is_of_interest || !shim().watches(path)) return open();
  const int descriptor = (flags & O_CREAT) != 0 ? act({"create", file_of(path), "-", 0}, open) : open();
  shim().note_open(descriptor, path);
  return descriptor;
}

mode_t mode_argument(int flags, va_list arguments) {
  return (flags & O_CREAT) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_argument(flags, arguments);
  va_end(arguments);
  return open_file("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_argument(flags, arguments);
  va_end(arguments);
  return open_file("open64", path, flags, mode);
}

ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t offset) {
  return act_on_write(descriptor, bytes, size, [&](size_t part) {
    return real<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite")(descriptor, bytes, part, offset);
  });
}

ssize_t pwrite64(int descriptor, const void* bytes, size_t size, off64_t offset) {
  return act_on_write(descriptor, bytes, size, [&](size_t part) {
    return real<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64")(descriptor, bytes, part, offset);
  });
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  return act_on_write(descriptor, bytes, size, [&](size_t part) {
    return real<ssize_t (*)(int, const void*, size_t)>("write")(descriptor, bytes, part);
  });
}

int ftruncate(int descriptor, off_t size) noexcept {
  const auto truncate = [&] { return real<int (*)(int, off_t)>("ftruncate")(descriptor, size); };
  const std::string path = shim().path_of(descriptor);
  return path.empty() ? truncate() : act({"ftruncate", file_of(path), "-", 0}, truncate);
}

int ftruncate64(int descriptor, off64_t size) noexcept {
  const auto truncate = [&] { return real<int (*)(int, off64_t)>("ftruncate64")(descriptor, size); };
  const std::string path = shim().path_of(descriptor);
  return path.empty() ? truncate() : act({"ftruncate", file_of(path), "-", 0}, truncate);
}

int fsync(int descriptor) {
  const auto sync = [&] { return real<int (*)(int)>("fsync")(descriptor); };
  const std::string path = shim().path_of(descriptor);
  return path.empty() ? sync() : act({"fsync", file_of(path), "-", 0}, sync);
}

int dup(int descriptor) noexcept {
  const int copy = real<int (*)(int)>("dup")(descriptor);
  const std::string path = shim().path_of(descriptor);
  if (copy >= 0) shim().note_open(copy, path.c_str());
  return copy;
}

int close(int descriptor) {
  const std::string path = shim().path_of(descriptor);
  shim().note_open(descriptor, "");
  const auto close = [&] { return real<int (*)(int)>("close")(descriptor); };
  if (path.empty()) return close();
  const int result = act({"close", file_of(path), "-", 0}, close);
  const int error = errno;
  if (result != 0) close();  // a close() that reports an error has closed all the same
  errno = error;
  return result;
}

int clock_gettime(clockid_t clock, struct timespec* time) noexcept {
  constexpr std::int64_t kDay = 86'400;
  const int result = real<int (*)(clockid_t, struct timespec*)>("clock_gettime")(clock, time);
  if (is_ready && clock == CLOCK_MONOTONIC && shim().is_late()) time->tv_sec += kDay;
  return result;
}

int rename(const char* from, const char* to) noexcept {
  const auto rename = [&] { return real<int (*)(const char*, const char*)>("rename")(from, to); };
  return shim().watches(to) ? act({"rename", file_of(to), "-", 0}, rename) : rename();
}

int mkdir(const char* path, mode_t mode) noexcept {
  const auto make = [&] { return real<int (*)(const char*, mode_t)>("mkdir")(path, mode); };
  return shim().watches(path) ? act({"mkdir", file_of(path), "-", 0}, make) : make();
}

int unlink(const char* path) noexcept {
  const auto unlink = [&] { return real<int (*)(const char*)>("unlink")(path); };
  return shim().watches(path) ? act({"unlink", file_of(path), "-", 0}, unlink) : unlink();
}

int rmdir(const char* path) noexcept {
  const auto remove = [&] { return real<int (*)(const char*)>("rmdir")(path); };
  return shim().watches(path) ? act({"rmdir", file_of(path), "-", 0}, remove) : remove();
}

}  // extern "C"
