#include <algorithm>

#include "core/error.hpp"
#include "pipeline/facts/option_table.hpp"
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

std::string schemes_text(const char* nodes::Scheme::*text) {
  std::string all;
  for (const nodes::Scheme* scheme : schemes())
    all += fmt::format("{}{}: {}", all.empty() ? "" : "; ", scheme->name, scheme->*text);
  return all;
}

void refuse_options_of_other_schemes(const facts::BuildOptions& options) {
  const nodes::Scheme& own = scheme_named(options.scheme);
  check_types(own.options, options.of_scheme);
  for (const auto& [name, value] : options.of_scheme) {
    const auto option_in = [&, &name = name](const nodes::Scheme& scheme) {
      return std::find_if(scheme.options.begin(), scheme.options.end(),
                          [&](const facts::SchemeOption& option) { return option.name == name; });
    };
    if (option_in(own) != own.options.end()) continue;
    std::string owners;
    bool is_default = false;  // asks for nothing
    for (const nodes::Scheme* scheme : schemes())
      if (const auto option = option_in(*scheme); option != scheme->options.end()) {
        owners += fmt::format("{}{}", owners.empty() ? "" : " or ", scheme->name);
        is_default = is_default || value == option->fallback;
      }
    if (owners.empty()) core::fail(core::Status::kUsage, "{} is no option", facts::flag_of(name));
    if (!is_default)
      core::fail(core::Status::kUsage, "{} is an option of --scheme {} only", facts::flag_of(name), owners);
  }
}

}  // namespace colossus::pipeline
