#include "build/scheme.hpp"

#include <algorithm>
#include <array>

#include "build/blocks/blocks.hpp"
#include "build/diamonds/diamonds.hpp"

namespace colossus::build {

std::span<const Scheme> schemes() {
  static constexpr std::array<Scheme, 2> kSchemes{
      {{container::kSchemeDiamonds, &check_diamonds, &build_diamonds},
       {container::kSchemeBlocks, &check_blocks, &build_blocks}}};
  return kSchemes;
}

const Scheme& scheme_named(std::string_view name) {
  const auto all = schemes();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Scheme& s) { return s.name == name; });
  if (found != all.end()) return *found;
  std::string names;
  for (const Scheme& scheme : all) names += fmt::format("{}{}", names.empty() ? "" : ", ", scheme.name);
  core::fail(core::Status::kUsage, "--scheme {} is unknown; choose one of {}", name, names);
}

}  // namespace colossus::build
