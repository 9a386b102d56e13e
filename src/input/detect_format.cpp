// Which format a file has. Content decides: statues come as .ply that are STL, and as .stl of either kind.
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "input/formats.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;
using namespace std::string_view_literals;

constexpr std::size_t kLook = 1 << 14;

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

bool is_white(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// The text that begins a file, behind a byte order mark.
std::string beginning_of(const core::File& file) {
  std::string text(kLook, '\0');
  text.resize(file.read_some_at(0, std::as_writable_bytes(std::span(text))));
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

// The first word that is no comment, in lower case; as much of it as there is. Reads on where a file begins
// with comments or blanks without end.
std::string first_word(const core::File& file, std::string text) {
  bool is_comment = false;
  for (std::uint64_t offset = 0;;) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      is_comment = text[i] != '\n' && text[i] != '\r' && (is_comment || text[i] == '#');
      if (is_comment || is_white(text[i])) continue;
      const std::size_t end = std::min(text.find_first_of(" \t\n\v\f\r", i), text.size());
      return lower(std::string_view(text).substr(i, end - i));
    }
    offset += kLook;
    text.assign(kLook, '\0');
    text.resize(file.read_some_at(offset, std::as_writable_bytes(std::span(text))));
    if (text.empty()) return {};
  }
}

// What a file is that somebody took for a statue; empty for anything else.
std::string foreign_name(const std::string& text) {
  constexpr std::pair<std::string_view, const char*> kStarts[] = {
      {"\x1f\x8b", "is compressed by gzip: unpack it"},
      {"PK\x03\x04", "is a zip archive: unpack it"},
      {"PK\x05\x06", "is an empty zip archive"},
      {"PK\x07\x08", "is a part of a zip archive: unpack it"},
      {"\x1f\x9d", "is compressed by compress: unpack it"},
      {"BZh", "is compressed by bzip2: unpack it"},
      {"\xFD"
       "7zXZ",
       "is compressed by xz: unpack it"},
      {"\x28\xB5\x2F\xFD", "is compressed by zstd: unpack it"},
      {"7z\xBC\xAF\x27\x1C", "is a 7z archive: unpack it"},
      {"Rar!", "is a rar archive: unpack it"},
      {"\x89HDF", "is an HDF5 file, maybe a container already"},
      {"glTF", "is a binary glTF: convert it to PLY"},
      {"\xFF\xFE", "is UTF-16: convert it to UTF-8"},
      {"\xFE\xFF", "is UTF-16: convert it to UTF-8"}};
  for (const auto& [start, name] : kStarts)
    if (text.starts_with(start)) return name;
  // Without a byte order mark every second byte of a Latin text is 0.
  if (text.size() >= 8 &&
      (text.starts_with(std::string{text[0], '\0', text[2], '\0', text[4], '\0'}) ||
       text.starts_with(std::string{'\0', text[1], '\0', text[3], '\0', text[5]})) &&
      text.substr(0, 6) != "\0\0\0\0\0\0"sv)
    return "is UTF-16: convert it to UTF-8";
  if (text.starts_with("version https://git-lfs") ||
      (text.starts_with("version http") && text.find("\noid sha256:") < 200))
    return fmt::format(
        "is a Git LFS pointer ('{}'), not the file that it stands for: fetch it by git lfs pull",
        text.substr(0, std::min<std::size_t>(text.find_first_of("\r\n"), 60)));
  const std::string start =
      lower(std::string_view(text).substr(std::min(text.find_first_not_of(" \t\r\n"), text.size()), 14));
  if (start.starts_with("<!doctype html") || start.starts_with("<html"))
    return "is an HTML page, not the file that was to be downloaded";
  return {};
}

// A binary STL has the size that its count says, and at most a few bytes or padding more; "solid" at its
// start says nothing.
bool has_size_of_binary_stl(const core::File& file) {
  const std::uint64_t count = binary_stl_count(file);
  const std::uint64_t bytes = binary_stl_bytes(count);
  if (count == 0 || file.size() < bytes) return false;
  return file.size() - bytes < binary_stl_bytes(1) - binary_stl_bytes(0) || tail_of(file, bytes).is_padding;
}

bool starts_with_obj(std::string_view word) {
  for (std::string_view known : {"v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"})
    if (word == known) return true;
  return false;
}
bool starts_with_off(std::string_view word) {
  return word.substr(0, word.find_first_of("0123456789", 1)).ends_with("off");
}

}  // namespace

FileFormat detect_format(const core::File& file) {
  constexpr const char* kExpected = "expected a PLY, OBJ, STL or OFF file";
  const std::string text = beginning_of(file);
  if (text.empty()) fail(Status::kBadData, "{}: is empty; {}", file.path().string(), kExpected);
  if (has_size_of_binary_stl(file)) return FileFormat::kBinaryStl;
  if (text.starts_with("ply") && text.size() > 3 && is_white(text[3])) return FileFormat::kPly;
  if (const std::string foreign = foreign_name(text); !foreign.empty())
    fail(Status::kBadData, "{}: {}; {}", file.path().string(), foreign, kExpected);
  const std::string word = first_word(file, text);
  // What begins with "solid" and is not of the size of a binary STL. Floats and counts have zeros, and text
  // has none but behind its end.
  const std::string head = text.substr(0, std::min<std::size_t>(text.size(), 1000));
  if (word.starts_with("solid"))
    return head.substr(0, head.find_last_not_of('\0') + 1).find('\0') == std::string::npos
               ? FileFormat::kAsciiStl
               : FileFormat::kBinaryStl;
  if (starts_with_off(word)) return FileFormat::kOff;
  if (starts_with_obj(word)) return FileFormat::kObj;
  const std::string extension = lower(file.path().extension().string());
  if (extension == ".ply") return FileFormat::kPly;
  if (extension == ".obj") return FileFormat::kObj;
  if (extension == ".stl") return FileFormat::kBinaryStl;
  if (extension == ".off" || extension == ".coff" || extension == ".noff" || extension == ".cnoff")
    return FileFormat::kOff;
  fail(Status::kBadData, "{}: unknown format; {}", file.path().string(), kExpected);
}

}  // namespace colossus::input
