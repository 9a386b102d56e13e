#include "core/output_file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

#include "core/error.hpp"

namespace colossus::core {
namespace {

constexpr int kPatienceMilliseconds = 50;

}  // namespace

OutputFile::OutputFile(OutputTarget target, WhileWaiting while_waiting)
    : target_(std::move(target)), while_waiting_(std::move(while_waiting)) {
  if (target_.is_stream) {
    open_stream();
    return;
  }
  file_ = File::create_anew(part_of(target_.path));
  struct stat info {};
  if (::fstat(file_.descriptor(), &info) != 0)
    fail(Status::kIo, "{}: cannot stat: {}", file_.path().string(), std::strerror(errno));
  inode_ = {info.st_dev, info.st_ino};
}

OutputFile::~OutputFile() {
  if (stream_ >= 0) ::close(stream_);
  if (!target_.is_stream && !is_committed_ && has_part()) ::unlink(part_of(target_.path).c_str());
}

// Whether the name still leads to our file: another process may have begun another one since.
bool OutputFile::has_part() const {
  struct stat info {};
  return ::stat(part_of(target_.path).c_str(), &info) == 0 && inode_ == std::pair(info.st_dev, info.st_ino);
}

// What was given to us open is written on from where it stands: it may be one of several that write to a
// file.
void OutputFile::open_stream() {
  if (target_.descriptor >= 0) {
    stream_ = ::fcntl(target_.descriptor, F_DUPFD_CLOEXEC, 0);
  } else {
    const int flags = O_WRONLY | O_CLOEXEC | O_NOCTTY | (while_waiting_ ? O_NONBLOCK : 0);
    while ((stream_ = ::open(target_.path.c_str(), flags)) < 0) {
      // A pipe that nobody reads yet says so by ENXIO.
      if (errno != EINTR && !(errno == ENXIO && while_waiting_)) break;
      if (!while_waiting_) continue;
      while_waiting_();
      ::poll(nullptr, 0, kPatienceMilliseconds);
    }
  }
  if (stream_ < 0)
    fail(create_status(errno), "{}: cannot open: {}", target_.path.string(), std::strerror(errno));
}

void OutputFile::wait_for_room() {
  for (;;) {
    struct pollfd request {};
    request.fd = stream_;
    request.events = POLLOUT;
    // Where there is nothing to wait for, write() says why.
    if (::poll(&request, 1, kPatienceMilliseconds) > 0) return;
    if (while_waiting_) while_waiting_();
  }
}

void OutputFile::append(std::span<const std::byte> bytes) {
  if (!target_.is_stream) {
    file_.write_at(size_, bytes);
    size_ += bytes.size();
    return;
  }
  while (!bytes.empty()) {
    if (while_waiting_) wait_for_room();
    // So much is taken at once by a pipe that has room, also by one that would let a larger write wait.
    const std::size_t step = while_waiting_ ? std::min<std::size_t>(bytes.size(), PIPE_BUF) : bytes.size();
    const ssize_t put = ::write(stream_, bytes.data(), step);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0 && errno == EAGAIN) {
      wait_for_room();  // somebody else has made the pipe so
      continue;
    }
    if (put == 0) errno = EIO;  // a device that takes nothing, and would be asked for ever
    if (put <= 0)
      fail(write_status(errno), "{}: cannot write {} bytes: {}", target_.path.string(), bytes.size(),
           std::strerror(errno));
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
}

// Pipes and most devices have nothing to flush, and say so.
void OutputFile::sync_stream() {
  if (::fsync(stream_) != 0 && errno != EINVAL && errno != ENOTSUP && errno != EROFS)
    fail(write_status(errno), "{}: cannot flush to disk: {}", target_.path.string(), std::strerror(errno));
}

void OutputFile::commit(Durability durability) {
  const bool is_to_be_synced = durability == Durability::kOnTheDevice;
  if (target_.is_stream) {
    if (is_to_be_synced) sync_stream();
    if (::close(std::exchange(stream_, -1)) != 0)
      fail(write_status(errno), "{}: cannot close: {}", target_.path.string(), std::strerror(errno));
    return;
  }
  if (is_to_be_synced) file_.sync();
  file_.close();
  const std::filesystem::path part = part_of(target_.path);
  if (!has_part())
    fail(Status::kIo, "{}: was removed or replaced while it was written: does another program write it?",
         part.string());
  if (::rename(part.c_str(), target_.path.c_str()) != 0)
    fail(create_status(errno), "{}: cannot rename to {}: {}", part.string(), target_.path.string(),
         std::strerror(errno));
  is_committed_ = true;
}

}  // namespace colossus::core
