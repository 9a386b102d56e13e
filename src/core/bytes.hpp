// Bounded little-endian reading and writing of bytes. The writer appends to a vector; the reader never reads
// past its span: it returns zeros from the first read that does not fit, and says so in failed().
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace colossus::core {

static_assert(std::endian::native == std::endian::little, "records and chunks are little-endian in memory");

using Bytes = std::vector<std::byte>;

template <typename T>
std::span<const std::byte> as_bytes(std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::as_bytes(values);
}

template <typename T>
std::span<const std::byte> as_bytes(const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::as_bytes(std::span<const T>(values));
}

class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes(std::as_bytes(std::span<const T, 1>(&value, 1)));
  }
  template <typename T>
  void put_array(std::span<const T> values) {
    put_bytes(as_bytes(values));
  }
  void put_bytes(std::span<const std::byte> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::size_t size() const { return bytes_.size(); }
  const Bytes& bytes() const { return bytes_; }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    if (const auto part = get_bytes(sizeof(T)); !part.empty()) std::memcpy(&value, part.data(), sizeof(T));
    return value;
  }

  // `count` values, or none when fewer are left. Allocates nothing before the size is known to fit.
  template <typename T>
  std::vector<T> get_array(std::uint64_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (failed_ || count > remaining() / sizeof(T)) {
      failed_ = true;
      return {};
    }
    std::vector<T> values(count);
    const auto part = get_bytes(count * sizeof(T));
    if (!part.empty()) std::memcpy(values.data(), part.data(), part.size());
    return values;
  }

  std::span<const std::byte> get_bytes(std::uint64_t size) {
    if (failed_ || size > remaining()) {
      failed_ = true;
      return {};
    }
    const auto part = bytes_.subspan(offset_, size);
    offset_ += size;
    return part;
  }

  bool failed() const { return failed_; }
  std::uint64_t offset() const { return offset_; }
  std::uint64_t remaining() const { return bytes_.size() - offset_; }

 private:
  std::span<const std::byte> bytes_;
  std::uint64_t offset_ = 0;
  bool failed_ = false;
};

}  // namespace colossus::core
