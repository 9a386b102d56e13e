// An output while it is written, from front to back: a file that appears when it is complete, or a stream.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <span>
#include <utility>

#include "core/file.hpp"
#include "core/outputs.hpp"

namespace colossus::core {

class OutputFile {
 public:
  // Called again and again while a stream keeps us waiting, which it then never does for longer than 50 ms at
  // a time; it throws to give up. Without one, opening a pipe waits for its reader, and writing for the room.
  using WhileWaiting = std::function<void()>;

  // Creates PATH.part anew, or opens the stream as it is. Throws Error with create_status().
  explicit OutputFile(OutputTarget target, WhileWaiting while_waiting = {});
  // Removes a file that is not committed.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  // Writes all of it. Throws Error with write_status(): a pipe without a reader is kIo (ignore SIGPIPE to see
  // it).
  void append(std::span<const std::byte> bytes);

  enum class Durability { kNone, kOnTheDevice };
  // Closes, and renames a file. Throws Error(kIo), also when another process has put something else under the
  // name of the part, Error(kNoResources) or Error(kCannotCreate).
  void commit(Durability durability);

 private:
  void open_stream();
  void wait_for_room();
  void sync_stream();
  bool has_part() const;

  OutputTarget target_;
  WhileWaiting while_waiting_;
  File file_;                      // PATH.part
  std::pair<dev_t, ino_t> inode_;  // of it
  std::uint64_t size_ = 0;
  int stream_ = -1;
  bool is_committed_ = false;
};

}  // namespace colossus::core
