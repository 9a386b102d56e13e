// Words and lines of a text file, read through a bounded buffer. Lines end at \n, \r\n or \r.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/file.hpp"
#include "input/byte_window.hpp"

namespace colossus::input {

// The whole word as a number, or nothing. from_chars' syntax, plus a leading '+'; "nan" and "inf" are
// numbers; what is too small for a double is 0, what is too large is infinite.
std::optional<double> parse_double(std::string_view word);
std::optional<std::int64_t> parse_int(std::string_view word);

class TextReader {
 public:
  struct Syntax {
    bool comments = false;       // a word that starts with # ends its line
    bool continuations = false;  // a backslash at the end of a line joins it with the next
  };

  // Starts at `offset`, which is the start of a line, and skips a byte order mark there. The file must
  // outlive it.
  TextReader(const core::File& file, std::uint64_t offset, Syntax syntax);

  // Goes to the next line that has a word (at first: the first one). False at the end of the file.
  bool next_row();
  // The next word of this line; empty at its end. Valid until the next call of anything.
  // Throws Error(kBadData) for a word of more than 1000 characters.
  std::string_view word();
  // The next word of this or a later line; empty at the end of the file.
  std::string_view word_of_any_line();
  // The number, from 1, of the current line.
  std::uint64_t line() const { return line_; }
  std::uint64_t remaining() const { return window_.remaining(); }

 private:
  bool skip_blanks();
  void skip_rest_of_line();

  const core::File& file_;
  Syntax syntax_;
  ByteWindow window_;
  std::uint64_t line_ = 1;
  bool started_ = false;
};

}  // namespace colossus::input
