#include "pipeline/schemes.hpp"

#include <algorithm>
#include <array>

#include "pipeline/blocks/scheme.hpp"
#include "pipeline/diamonds/scheme.hpp"

namespace colossus::pipeline {

std::span<const nodes::Scheme> schemes() {
  static constexpr std::array<nodes::Scheme, 2> kSchemes{
      {{container::kSchemeDiamonds, &diamonds::check_diamonds, &diamonds::build_diamonds},
       {container::kSchemeBlocks, &blocks::check_blocks, &blocks::build_blocks}}};
  return kSchemes;
}

const nodes::Scheme& scheme_named(std::string_view name) {
  const auto all = schemes();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const nodes::Scheme& s) { return s.name == name; });
  if (found != all.end()) return *found;
  std::string names;
  for (const nodes::Scheme& scheme : all)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", scheme.name);
  core::fail(core::Status::kUsage, "--scheme {} is unknown; choose one of {}", name, names);
}

}  // namespace colossus::pipeline
