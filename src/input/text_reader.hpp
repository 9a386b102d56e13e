// Words and lines of a text file, read through a bounded buffer. Lines end at \n, \r\n or \r.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/file.hpp"
#include "input/byte_window.hpp"
#include "input/source.hpp"

namespace colossus::input {

// The whole word as a number, or nothing. from_chars' syntax, plus a leading '+'; "nan" and "inf" are
// numbers, also as C libraries for Windows write them (1.#QNAN, -1.#IND, 1.#INF); what is too small for a
// double is 0, what is too large is infinite.
std::optional<double> parse_double(std::string_view word);
std::optional<std::int64_t> parse_int(std::string_view word);
// An integer, or a float whose value is one, such as 3.0.
std::optional<std::int64_t> parse_float_int(std::string_view word);

// What lies behind the data, from `offset` to the end of the file.
struct Tail {
  std::uint64_t bytes = 0;
  bool is_white = true;
  bool is_padding = true;  // zeros, white space, and the Ctrl-Z with which DOS ended texts
};
// Reads all of it.
Tail tail_of(const core::File& file, std::uint64_t offset);
// Remarks a tail, but for a little white space. Throws Error(kBadData) unless it is padding, or options say
// is_lenient. `line`: where it begins, if the file has lines.
void check_tail(const SourceInfo& info, const SourceOptions& options, const core::File& file,
                std::uint64_t offset, Remarks& remarks, std::uint64_t line = 0);

class TextReader {
 public:
  struct Syntax {
    bool comments = false;  // a word that starts with # ends its line
    bool continuations =
        false;  // a backslash at the end of a line, or before blanks there, joins it with the next
  };

  // Starts at `offset`, which is the start of a line, and skips a byte order mark there. The text ends before
  // padding(). The file must outlive it.
  TextReader(const core::File& file, std::uint64_t offset, Syntax syntax);

  // Goes to the next line that has a word (at first: the first one). False at the end of the file.
  bool next_row();
  // The next word of this line; empty at its end. Valid until the next call of anything.
  // Throws Error(kBadData) for a word of more than 1000 characters, of which keyword() returns the first
  // ones.
  std::string_view word();
  std::string_view keyword();
  // The next word of this or a later line; empty at the end of the file.
  std::string_view word_of_any_line();
  // Whether there is another word on this line.
  bool has_word() { return skip_blanks(); }
  // Whether the next byte of the row, behind blanks, can begin a word of text: no control character, and
  // ASCII.
  bool is_at_text();
  // The number, from 1, of the current line.
  std::uint64_t line() const { return line_; }
  std::uint64_t remaining() const { return window_.remaining(); }
  // Of the next byte, in the file.
  std::uint64_t offset() const { return window_.offset(); }
  // How many zeros, with blanks and Ctrl-Z between them, end the file. Others are characters like all.
  std::uint64_t padding() const { return padding_; }

 private:
  std::string_view next_word(bool may_be_long);
  bool skip_blanks();
  bool skip_continuation();
  bool skip_to_line_end();
  void skip_rest_of_line();

  const core::File& file_;
  Syntax syntax_;
  std::uint64_t padding_;
  ByteWindow window_;
  std::uint64_t line_ = 1;
  bool started_ = false;
};

}  // namespace colossus::input
