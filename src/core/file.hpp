// Files by descriptor: positioned reads and writes that are complete or throw core::Error, never short.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::core {

// What a failed write with this errno is: kNoResources when there is no room, else kIo.
Status write_status(int error);
// What a failure to create or rename a file with this errno is: kNoResources when there is no room, kIo when
// the device fails, else kCannotCreate.
Status create_status(int error);

class File {
 public:
  File() = default;
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  // Throws Error(kBadData) when the file cannot be opened, or is no regular file: a missing input is bad
  // input, and a pipe or a device could be read once only, by one rank. Never waits for somebody else.
  static File open_for_reading(const std::filesystem::path& path);
  // Creates the file, which must not exist when `exclusive`; else truncates it. Throws Error with
  // create_status().
  static File create(const std::filesystem::path& path, bool exclusive = false);

  // Creates a file that is new even if there is one of this name, which goes: others may hold that one open,
  // and other names may lead to it. Throws Error with create_status().
  static File create_anew(const std::filesystem::path& path);

  bool is_open() const { return descriptor_ >= 0; }
  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const;
  // Reads up to buffer.size() bytes at offset; fewer only at the end of the file. Throws Error(kIo).
  std::size_t read_some_at(std::uint64_t offset, std::span<std::byte> buffer) const;
  // Reads exactly buffer.size() bytes; throws Error(kBadData) that names file, offset, expected and found
  // size.
  void read_at(std::uint64_t offset, std::span<std::byte> buffer) const;
  // Writes everything at offset. Throws Error(kIo), or Error(kNoResources) when the disk is full or the
  // file too large for its file system or the process's limit (ignore SIGXFSZ to see that one).
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  // Flushes to the device. Throws Error(kIo).
  void sync();
  // Closes and reports a delayed write error, which a destructor could not. Throws Error(kIo).
  void close();
  int descriptor() const { return descriptor_; }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

// Throws Error(kBadData) for an empty name of an input, and for one that means a descriptor, such as
// /dev/stdin, also through symbolic links: what that is may differ from rank to rank, and cannot be opened
// again when a build is resumed.
void check_input_name(const std::filesystem::path& input);

// All bytes of a file. Throws like File.
Bytes read_file(const std::filesystem::path& path);

}  // namespace colossus::core
