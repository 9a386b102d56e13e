#include "core/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/place.hpp"

namespace colossus::core {
namespace {

// Systems limit one call to about 2 GiB; a quarter of it keeps signals and progress responsive.
constexpr std::size_t kMaxCallBytes = std::size_t{1} << 29;

void require_regular(const std::filesystem::path& path, const struct stat& info) {
  if (!S_ISREG(info.st_mode))
    fail(Status::kBadData, "{}: is {}; expected a regular file", path.string(), kind_of(info.st_mode));
}

}  // namespace

// A limit on the size of files (ulimit -f) is a full disk too.
Status write_status(int error) {
  return error == ENOSPC || error == EDQUOT || error == EFBIG ? Status::kNoResources : Status::kIo;
}

Status create_status(int error) {
  if (error == EIO) return Status::kIo;
  const Status status = write_status(error);
  return status == Status::kNoResources ? status : Status::kCannotCreate;
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

File::File(File&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

File& File::operator=(File&& other) noexcept {
  if (this != &other) {
    if (descriptor_ >= 0) ::close(descriptor_);
    path_ = std::move(other.path_);
    descriptor_ = std::exchange(other.descriptor_, -1);
  }
  return *this;
}

File File::open_for_reading(const std::filesystem::path& path) {
  File file;
  file.path_ = path;
  // To open a pipe waits for a writer, and to open a device may do something: they are told before. A name
  // may change its meaning between the two calls, hence the flags and the second look.
  struct stat info {};
  if (::stat(path.c_str(), &info) == 0) require_regular(path, info);
  file.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  // Where somebody else has a lease on the file, opening waits until it is given back.
  if (file.descriptor_ < 0 && errno == EWOULDBLOCK)
    file.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY);
  if (file.descriptor_ < 0 || ::fstat(file.descriptor_, &info) != 0)
    fail(Status::kBadData, "{}: cannot open: {}", path.string(), std::strerror(errno));
  require_regular(path, info);
  return file;
}

File File::create_anew(const std::filesystem::path& path) {
  ::unlink(path.c_str());
  return create(path, true);
}

File File::create(const std::filesystem::path& path, bool exclusive) {
  File file;
  file.path_ = path;
  file.descriptor_ =
      ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | (exclusive ? O_EXCL : O_TRUNC), 0666);
  if (file.descriptor_ < 0)
    fail(create_status(errno), "{}: cannot create: {}", path.string(), std::strerror(errno));
  return file;
}

std::uint64_t File::size() const {
  struct stat info {};
  if (::fstat(descriptor_, &info) != 0)
    fail(Status::kIo, "{}: cannot stat: {}", path_.string(), std::strerror(errno));
  return static_cast<std::uint64_t>(info.st_size);
}

std::size_t File::read_some_at(std::uint64_t offset, std::span<std::byte> buffer) const {
  std::size_t done = 0;
  while (done < buffer.size()) {
    const std::size_t step = std::min(buffer.size() - done, kMaxCallBytes);
    const ssize_t got = ::pread(descriptor_, buffer.data() + done, step, static_cast<off_t>(offset + done));
    if (got < 0) {
      if (errno == EINTR) continue;
      fail(Status::kIo, "{}: cannot read at byte {}: {}", path_.string(), offset + done,
           std::strerror(errno));
    }
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

void File::read_at(std::uint64_t offset, std::span<std::byte> buffer) const {
  const std::size_t got = read_some_at(offset, buffer);
  if (got != buffer.size())
    fail(Status::kBadData, "{}: truncated: expected {} bytes at byte {}, found {}", path_.string(),
         buffer.size(), offset, got);
}

void File::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const std::size_t step = std::min(bytes.size() - done, kMaxCallBytes);
    const ssize_t put = ::pwrite(descriptor_, bytes.data() + done, step, static_cast<off_t>(offset + done));
    if (put <= 0) {
      if (put < 0 && errno == EINTR) continue;
      if (put == 0) errno = EIO;  // a device that takes nothing, and would be asked for ever
      fail(write_status(errno), "{}: cannot write {} bytes at byte {}: {}", path_.string(),
           bytes.size() - done, offset + done, std::strerror(errno));
    }
    done += static_cast<std::size_t>(put);
  }
}

void File::sync() {
  if (::fsync(descriptor_) != 0)
    fail(write_status(errno), "{}: cannot flush to disk: {}", path_.string(), std::strerror(errno));
}

void File::close() {
  const int descriptor = std::exchange(descriptor_, -1);
  if (descriptor >= 0 && ::close(descriptor) != 0)
    fail(write_status(errno), "{}: cannot close: {}", path_.string(), std::strerror(errno));
}

void check_input_name(const std::filesystem::path& input) {
  if (input.empty()) fail(Status::kBadData, "expected the name of a file to read, found an empty one");
  const Place place = place_of(input);
  if (place.is_descriptor)
    fail(Status::kBadData, "{}: is an open descriptor; expected the name of a regular file", input.string());
  if (is_in_proc(place.path))
    fail(Status::kBadData, "{}: is a file of /proc; expected a regular file on a disk", input.string());
}

Bytes read_file(const std::filesystem::path& path) {
  const File file = File::open_for_reading(path);
  Bytes bytes(file.size());
  file.read_at(0, bytes);
  return bytes;
}

}  // namespace colossus::core
