#include "core/escape.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace colossus::core {
namespace {

std::uint8_t byte_at(std::string_view text, std::size_t i) {
  return i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0;
}

// Bytes of the sequence that the text begins with; 0 for none. As in table 3-7 of the Unicode standard: no
// overlong forms, no surrogates, nothing above U+10FFFF.
std::size_t sequence_bytes(std::string_view text) {
  const std::uint8_t first = byte_at(text, 0);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4) return 0;
  std::uint8_t least = 0x80, most = 0xbf;  // of the second byte
  if (first == 0xe0) least = 0xa0;
  if (first == 0xed) most = 0x9f;
  if (first == 0xf0) least = 0x90;
  if (first == 0xf4) most = 0x8f;
  if (byte_at(text, 1) < least || byte_at(text, 1) > most) return 0;
  for (std::size_t i = 2; i < size; ++i)
    if ((byte_at(text, i) & 0xc0) != 0x80) return 0;
  return size;
}

}  // namespace

std::string escaped_text(std::string_view text) {
  std::string escaped;
  bool is_valid = true;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t size = sequence_bytes(rest);
    is_valid &= size > 0;
    if (size == 0)
      escaped += fmt::format("\\x{:02x}", byte_at(rest, 0));
    else if (rest.front() == '\\')
      escaped += "\\\\";
    else
      escaped += rest.substr(0, size);
    rest.remove_prefix(size == 0 ? 1 : size);
  }
  return is_valid ? std::string(text) : escaped;
}

}  // namespace colossus::core
