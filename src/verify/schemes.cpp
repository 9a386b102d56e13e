#include <array>

#include "verify/blocks/verify.hpp"
#include "verify/diamonds/verify.hpp"
#include "verify/verify.hpp"

namespace colossus::verify {

// In a file of its own: a program with schemes of its own brings its own table (tests/toy).
std::span<const Scheme> schemes() {
  using reader::access::Statue;
  static constexpr std::array<Scheme, 2> kSchemes{
      {{hierarchy::kDiamonds,
        [](const Statue& statue, const measure::VerifyOptions& options) {
          return diamonds::verify(dynamic_cast<const reader::diamonds::Statue&>(statue), options);
        }},
       {hierarchy::kBlocks, [](const Statue& statue, const measure::VerifyOptions& options) {
          return blocks::verify(dynamic_cast<const reader::blocks::Statue&>(statue), options);
        }}}};
  return kSchemes;
}

}  // namespace colossus::verify
