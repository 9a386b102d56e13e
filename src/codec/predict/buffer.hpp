// An array that nobody has to clear first: for what is written before it is read.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace colossus::codec::predict {

template <typename T>
class Buffer {
 public:
  explicit Buffer(std::size_t size) : values_(std::make_unique_for_overwrite<T[]>(size)), size_(size) {}
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  std::size_t size() const { return size_; }
  std::span<T> first(std::size_t count) { return {values_.get(), count}; }
  std::span<T> all() { return first(size_); }

 private:
  std::unique_ptr<T[]> values_;
  std::size_t size_;
};

}  // namespace colossus::codec::predict
