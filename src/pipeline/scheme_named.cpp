#include <algorithm>

#include "core/error.hpp"
#include "pipeline/schemes.hpp"

namespace colossus::pipeline {

const nodes::Scheme& scheme_named(std::string_view name) {
  const auto all = schemes();
  if (name.empty()) return *all.front();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const nodes::Scheme* s) { return s->name == name; });
  if (found != all.end()) return **found;
  std::string names;
  for (const nodes::Scheme* scheme : all)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", scheme->name);
  core::fail(core::Status::kUsage, "--scheme {} is unknown; choose one of {}", name, names);
}

std::string schemes_text() {
  std::string text;
  for (const nodes::Scheme* scheme : schemes())
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", scheme->name, scheme->description);
  return text;
}

}  // namespace colossus::pipeline
