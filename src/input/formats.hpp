// What a format of inputs is. A new one is a file with a Source and a Format, a line that declares it
// here, and one in the table of formats.cpp.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "core/file.hpp"
#include "input/source.hpp"

namespace colossus::input {

// What detection looks at.
struct FileStart {
  const core::File& file;
  std::string text;        // the first 16 KiB, behind a byte order mark
  std::string first_word;  // that is in no comment, in lower case
};

struct Format {
  const char* name;        // in messages
  const char* extensions;  // in lower case, such as ".off .coff"; they count where no content tells
  // Whether a size or magic number tells this format. Asked of all formats first, then whether the file is
  // something well known that is no mesh; may be null.
  bool (*is_certain)(const FileStart& start);
  // Whether the first words do; may be null.
  bool (*resembles)(const FileStart& start);
  // `file` is open for reading and not empty. The Source keeps what source.hpp promises.
  std::unique_ptr<Source> (*open)(core::File file, const SourceOptions& options);
};

// Each in the file of its source.
extern const Format kObjFormat;
extern const Format kOffFormat;
extern const Format kPlyFormat;
extern const Format kStlFormat;

// All of them, in the order in which they are asked.
std::span<const Format* const> formats();

// "PLY, OBJ, STL or OFF", for people.
std::string format_names();

}  // namespace colossus::input
