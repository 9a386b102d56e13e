#include "input/text_reader.hpp"

#include <charconv>
#include <cstdlib>
#include <string>

#include "core/error.hpp"

namespace colossus::input {
namespace {

constexpr std::size_t kMaxWord = 1000;

bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

// How many characters the line end at `at` has: 0 if there is none.
std::size_t line_end_size(const char* at, std::size_t size) {
  if (size >= 2 && at[0] == '\r' && at[1] == '\n') return 2;
  return size >= 1 && is_line_end(at[0]) ? 1 : 0;
}

}  // namespace

std::optional<double> parse_double(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || error == std::errc::invalid_argument) return {};
  // from_chars does not say on which side of the range the number lies.
  if (error == std::errc::result_out_of_range) return std::strtod(std::string(word).c_str(), nullptr);
  return value;
}

std::optional<std::int64_t> parse_int(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || error != std::errc()) return {};
  return value;
}

TextReader::TextReader(const core::File& file, std::uint64_t offset, Syntax syntax)
    : file_(file), syntax_(syntax), window_(file, offset, file.size()) {
  const auto bytes = window_.peek(3);
  if (bytes.size() >= 3 && std::memcmp(bytes.data(), "\xEF\xBB\xBF", 3) == 0) window_.consume(3);
}

// To the next word of this line. False at the end of the line or the file.
bool TextReader::skip_blanks() {
  while (true) {
    const auto bytes = window_.peek(kMaxWord + 3);
    if (bytes.empty()) return false;
    const char* text = reinterpret_cast<const char*>(bytes.data());
    std::size_t at = 0;
    while (at < bytes.size() && is_blank(text[at])) ++at;
    window_.consume(at);
    if (at + 3 > bytes.size() && window_.remaining() > bytes.size() - at)
      continue;  // look at the following bytes too
    if (at == bytes.size()) return false;
    if (is_line_end(text[at]) || (syntax_.comments && text[at] == '#')) return false;
    const std::size_t joined =
        syntax_.continuations && text[at] == '\\' ? line_end_size(text + at + 1, bytes.size() - at - 1) : 0;
    if (joined == 0) return true;
    window_.consume(1 + joined);
    ++line_;
  }
}

std::string_view TextReader::word() {
  if (!skip_blanks()) return {};
  const auto bytes = window_.peek(kMaxWord + 3);
  const char* text = reinterpret_cast<const char*>(bytes.data());
  std::size_t size = 0;
  for (; size < bytes.size() && !is_blank(text[size]) && !is_line_end(text[size]); ++size) {
    if (size > kMaxWord)
      core::fail(core::Status::kBadData, "{}: line {}: a word of more than {} characters; expected text",
                 file_.path().string(), line_, kMaxWord);
    if (syntax_.continuations && text[size] == '\\' &&
        line_end_size(text + size + 1, bytes.size() - size - 1) > 0)
      break;
  }
  window_.consume(size);
  return {text, size};
}

void TextReader::skip_rest_of_line() {
  if (syntax_.continuations)
    while (!word().empty()) {
    }
  while (true) {
    const auto bytes = window_.peek(2);
    if (bytes.empty()) return;
    const char* text = reinterpret_cast<const char*>(bytes.data());
    std::size_t at = 0;
    while (at < bytes.size() && !is_line_end(text[at])) ++at;
    window_.consume(at);
    if (at == bytes.size()) continue;
    const auto rest = window_.peek(2);
    window_.consume(line_end_size(reinterpret_cast<const char*>(rest.data()), rest.size()));
    ++line_;
    return;
  }
}

bool TextReader::next_row() {
  if (started_) skip_rest_of_line();
  started_ = true;
  while (!skip_blanks()) {
    if (window_.remaining() == 0) return false;
    skip_rest_of_line();
  }
  return true;
}

std::string_view TextReader::word_of_any_line() {
  started_ = true;
  while (!skip_blanks()) {
    if (window_.remaining() == 0) return {};
    skip_rest_of_line();
  }
  return word();
}

}  // namespace colossus::input
