#include "pipeline/schemes.hpp"

#include <array>

#include "pipeline/blocks/scheme.hpp"
#include "pipeline/diamonds/scheme.hpp"

namespace colossus::pipeline {

// In a file of its own: a program with schemes of its own brings its own table (tests/toy).
std::span<const nodes::Scheme* const> schemes() {
  static constexpr std::array<const nodes::Scheme*, 2> kSchemes{&diamonds::kScheme, &blocks::kScheme};
  return kSchemes;
}

}  // namespace colossus::pipeline
