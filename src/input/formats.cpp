#include "input/formats.hpp"

#include <array>

namespace colossus::input {

// In a file of its own: a program with formats of its own brings its own table (tests/toy).
std::span<const Format* const> formats() {
  static constexpr std::array<const Format*, 4> kFormats{&kPlyFormat, &kObjFormat, &kStlFormat, &kOffFormat};
  return kFormats;
}

}  // namespace colossus::input
