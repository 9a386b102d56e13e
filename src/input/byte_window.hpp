// A forward reader of a file with one bounded buffer, for formats whose elements have no fixed size.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/file.hpp"

namespace colossus::input {

class ByteWindow {
 public:
  static constexpr std::size_t kCapacity = std::size_t{1} << 20;

  // Starts at `offset`, which is at most `file_size`. The file must outlive the window.
  ByteWindow(const core::File& file, std::uint64_t offset, std::uint64_t file_size)
      : file_(file),
        next_(offset),
        file_size_(file_size),
        buffer_(std::min<std::uint64_t>(kCapacity, file_size - offset)) {}

  // All buffered bytes: at least `size` (at most kCapacity), or all that are left of the file.
  std::span<const std::byte> peek(std::size_t size) {
    if (end_ - begin_ < size && next_ < file_size_) refill();
    return {buffer_.data() + begin_, end_ - begin_};
  }
  // Goes on by `size` bytes, which a peek() has returned.
  void consume(std::size_t size) { begin_ += size; }
  // Goes on by any `size` of at most remaining() bytes, without reading them.
  void skip(std::uint64_t size) {
    const std::uint64_t buffered = std::min<std::uint64_t>(size, end_ - begin_);
    begin_ += buffered;
    next_ += size - buffered;
  }
  std::uint64_t offset() const { return next_ - (end_ - begin_); }
  std::uint64_t remaining() const { return file_size_ - offset(); }

 private:
  void refill() {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    const std::size_t step = std::min<std::uint64_t>(buffer_.size() - end_, file_size_ - next_);
    file_.read_at(next_, std::span(buffer_).subspan(end_, step));
    end_ += step;
    next_ += step;
  }

  const core::File& file_;
  std::uint64_t next_;  // file offset of the first byte behind the buffer
  std::uint64_t file_size_;
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
};

}  // namespace colossus::input
