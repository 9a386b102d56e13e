#include "input/detect_format.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.hpp"
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

std::string expected_text() { return fmt::format("expected a {} file", format_names()); }

bool has_extension(const Format& format, const core::File& file) {
  const std::string extension = lower(file.path().extension().string());
  return !extension.empty() &&
         fmt::format(" {} ", format.extensions).find(fmt::format(" {} ", extension)) != std::string::npos;
}

}  // namespace

std::string format_names() {
  std::string names;
  const auto all = formats();
  for (std::size_t i = 0; i < all.size(); ++i)
    names += fmt::format("{}{}", i == 0 ? "" : i + 1 < all.size() ? ", " : " or ", all[i]->name);
  return names;
}

FileStart start_of(const core::File& file) {
  FileStart start{file, beginning_of(file), {}};
  start.first_word = first_word(file, start.text);
  return start;
}

const Format& detect_format(const core::File& file) {
  if (beginning_of(file).empty())
    fail(Status::kBadData, "{}: is empty; {}", file.path().string(), expected_text());
  const FileStart start = start_of(file);
  for (const Format* format : formats())
    if (format->is_certain && format->is_certain(start)) return *format;
  if (const std::string foreign = foreign_name(start.text); !foreign.empty())
    fail(Status::kBadData, "{}: {}; {}", file.path().string(), foreign, expected_text());
  for (const Format* format : formats())
    if (format->resembles && format->resembles(start)) return *format;
  for (const Format* format : formats())
    if (has_extension(*format, file)) return *format;
  fail(Status::kBadData, "{}: unknown format; {}", file.path().string(), expected_text());
}

}  // namespace colossus::input
