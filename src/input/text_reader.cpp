#include "input/text_reader.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "core/error.hpp"

namespace colossus::input {
namespace {

constexpr std::size_t kMaxWord = 1000;
// White space behind the data that is not worth a word.
constexpr std::uint64_t kLittle = 64;

bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

// How many characters the line end at `at` has: 0 if there is none.
std::size_t line_end_size(const char* at, std::size_t size) {
  if (size >= 2 && at[0] == '\r' && at[1] == '\n') return 2;
  return size >= 1 && is_line_end(at[0]) ? 1 : 0;
}

// Zeros, white space, and the Ctrl-Z with which DOS ended texts.
bool is_padding(char c) { return is_line_end(c) || is_blank(c) || c == '\0' || c == '\x1a'; }

// Of the end of a text that begins at `offset`: 0 if it is only a little white space.
std::uint64_t padding_of(const core::File& file, std::uint64_t offset) {
  constexpr std::uint64_t kStep = 4096;
  const std::uint64_t size = file.size();
  bool is_white = true;
  std::array<std::byte, kStep> buffer;
  for (std::uint64_t end = size; end > offset;) {
    const std::uint64_t begin = end - std::min(kStep, end - offset);
    const std::size_t got = file.read_some_at(begin, std::span(buffer).first(end - begin));
    for (std::size_t i = got; i-- > 0;) {
      const char c = static_cast<char>(buffer[i]);
      const std::uint64_t bytes = size - (begin + i + 1);
      if (!is_padding(c)) return is_white && bytes <= kLittle ? 0 : bytes;
      is_white = is_white && c != '\0' && c != '\x1a';
    }
    end = begin;
  }
  return is_white ? 0 : size - std::min(offset, size);
}

// 1.#INF, 1.#QNAN, 1.#SNAN and 1.#IND, with a sign and digits behind: as printf() of C libraries for Windows
// wrote what is no number; and what became of these when it rounded them to fewer digits, as if letters were
// such.
std::optional<double> parse_windows_number(std::string_view word) {
  const bool is_negative = word.starts_with('-');
  if (is_negative) word.remove_prefix(1);
  if (!word.starts_with("1.#")) return {};
  word.remove_prefix(3);
  while (!word.empty() && word.back() >= '0' && word.back() <= '9') word.remove_suffix(1);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (word == "INF") return is_negative ? -kInfinity : kInfinity;
  for (const std::string_view known : {"QNAN", "SNAN", "IND", "J", "IO", "R", "QO", "T", "SO"})
    if (word == known) return std::numeric_limits<double>::quiet_NaN();
  return {};
}

}  // namespace

std::optional<double> parse_double(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return parse_windows_number(word);
  if (error == std::errc::invalid_argument) return {};
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

std::optional<std::int64_t> parse_float_int(std::string_view word) {
  if (const auto value = parse_int(word)) return value;
  const auto value = parse_double(word);
  constexpr double kExact = 0x1p53;  // up to here doubles hold every integer
  if (!value || !(std::abs(*value) <= kExact) || std::trunc(*value) != *value) return {};
  return static_cast<std::int64_t>(*value);
}

Tail tail_of(const core::File& file, std::uint64_t offset) {
  Tail tail{file.size() - std::min(offset, file.size())};
  std::vector<std::byte> buffer(std::min<std::uint64_t>(tail.bytes, ByteWindow::kCapacity));
  for (std::uint64_t done = 0; done < tail.bytes && tail.is_padding;) {
    const std::size_t got = file.read_some_at(offset + done, buffer);
    if (got == 0) break;
    for (std::size_t i = 0; i < got; ++i) {
      const char c = static_cast<char>(buffer[i]);
      tail.is_white = tail.is_white && (is_line_end(c) || is_blank(c));
      tail.is_padding = tail.is_padding && is_padding(c);
    }
    done += got;
  }
  return tail;
}

void check_tail(const SourceInfo& info, const SourceOptions& options, const core::File& file,
                std::uint64_t offset, Remarks& remarks, std::uint64_t line) {
  const Tail tail = tail_of(file, offset);
  if (tail.is_white && tail.bytes <= kLittle) return;
  if (tail.is_padding) {
    remarks.trailing_padding += tail.bytes;
  } else if (options.is_lenient) {
    remarks.trailing_bytes += tail.bytes;
  } else {
    std::array<std::byte, 1> first{};
    file.read_some_at(offset, first);
    core::fail(
        core::Status::kBadData,
        "{}: expected the end of the file behind the data, at byte {}{}, found {} more bytes, the first is "
        "{:#04x}; --lenient lets them pass",
        info.path.string(), offset, line > 0 ? fmt::format(" (line {})", line) : "", tail.bytes,
        std::to_integer<int>(first[0]));
  }
}

TextReader::TextReader(const core::File& file, std::uint64_t offset, Syntax syntax)
    : file_(file),
      syntax_(syntax),
      padding_(padding_of(file, offset)),
      window_(file, offset, file.size() - padding_) {
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
    if (!syntax_.continuations || text[at] != '\\' || !skip_continuation()) return true;
  }
}

// Goes on behind the line end if only blanks are between it and the backslash that is next. There may be
// many.
bool TextReader::skip_continuation() {
  const std::uint64_t begin = window_.offset();
  const std::uint64_t text_end = begin + window_.remaining();  // not the file's, which may be padded
  std::uint64_t end = begin + 1;
  for (std::array<std::byte, 256> buffer;; end += buffer.size()) {
    const std::size_t most = std::min<std::uint64_t>(buffer.size(), text_end - end);
    const std::size_t got = file_.read_some_at(end, std::span(buffer).first(most));
    const char* text = reinterpret_cast<const char*>(buffer.data());
    std::size_t at = 0;
    while (at < got && is_blank(text[at])) ++at;
    if (at == buffer.size()) continue;
    end += at;
    if (end == text_end) break;  // what goes on where the text ends
    if (at == got || !is_line_end(text[at])) return false;
    std::array<std::byte, 2> rest{};
    const std::size_t left = std::min<std::uint64_t>(rest.size(), text_end - end);
    end += line_end_size(reinterpret_cast<const char*>(rest.data()),
                         file_.read_some_at(end, std::span(rest).first(left)));
    break;
  }
  window_.skip(end - begin);
  ++line_;
  return true;
}

std::string_view TextReader::word() { return next_word(false); }

std::string_view TextReader::keyword() { return next_word(true); }

std::string_view TextReader::next_word(bool may_be_long) {
  if (!skip_blanks()) return {};
  const auto bytes = window_.peek(kMaxWord + 3);
  const char* text = reinterpret_cast<const char*>(bytes.data());
  std::size_t size = 0;
  for (; size < bytes.size() && !is_blank(text[size]) && !is_line_end(text[size]); ++size) {
    if (size > kMaxWord && may_be_long) break;
    if (size > kMaxWord)
      core::fail(core::Status::kBadData, "{}: line {}: a word of more than {} characters; expected text",
                 file_.path().string(), line_, kMaxWord);
    if (syntax_.continuations && text[size] == '\\' &&
        (size + 1 == bytes.size() || is_blank(text[size + 1]) || is_line_end(text[size + 1])))
      break;  // what follows may be the next line
  }
  // A backslash that continues nothing is a word.
  if (size == 0) size = 1;
  window_.consume(size);
  return {text, size};
}

// To the line end, or the file's. Whether a backslash comes last, outside of a comment.
bool TextReader::skip_to_line_end() {
  bool is_comment = false;
  char last = '\0';
  char before = ' ';  // a word begins behind a blank
  while (true) {
    const auto bytes = window_.peek(2);
    const char* text = reinterpret_cast<const char*>(bytes.data());
    std::size_t at = 0;
    for (; at < bytes.size() && !is_line_end(text[at]); before = text[at++]) {
      is_comment = is_comment || (syntax_.comments && text[at] == '#' && is_blank(before));
      if (!is_blank(text[at])) last = text[at];
    }
    const bool is_end = at < bytes.size() || bytes.empty();
    window_.consume(at);
    if (is_end) return last == '\\' && !is_comment;
  }
}

void TextReader::skip_rest_of_line() {
  while (true) {
    const bool is_continued = skip_to_line_end() && syntax_.continuations;
    const auto rest = window_.peek(2);
    if (rest.empty()) return;
    window_.consume(line_end_size(reinterpret_cast<const char*>(rest.data()), rest.size()));
    ++line_;
    if (!is_continued) return;
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

bool TextReader::is_at_text() {
  if (!skip_blanks()) return true;
  const auto c = std::to_integer<unsigned char>(window_.peek(1)[0]);
  return c >= ' ' && c < 0x7F;
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
