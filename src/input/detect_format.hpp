// Which format a file has. Content decides: statues come as .ply that are STL, and as .stl of either kind.
#pragma once

#include "input/formats.hpp"

namespace colossus::input {

// By content, then by extension. Throws Error(kBadData) for an empty file, for what is none of the formats,
// and, saying what it is, for what is packed, UTF-16, or only stands for a file.
const Format& detect_format(const core::File& file);
FileStart start_of(const core::File& file);

}  // namespace colossus::input
