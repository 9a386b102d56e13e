#include "input/formats.hpp"

#include <array>

namespace colossus::input {

extern const Format kObjFormat;
extern const Format kOffFormat;
extern const Format kPlyFormat;
extern const Format kStlFormat;

// In a file of its own: a program with formats of its own brings its own table.
std::span<const Format* const> formats() {
  static constexpr std::array<const Format*, 4> kFormats{&kPlyFormat, &kObjFormat, &kStlFormat, &kOffFormat};
  return kFormats;
}

}  // namespace colossus::input
