#include "pipeline/facts/scheme_options.hpp"

#include <fmt/format.h>

namespace colossus::pipeline::facts {

std::string text_of(const OptionValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

std::vector<container::NamedText> stored_values(std::span<const SchemeOption> options,
                                                const SchemeValues& values) {
  std::vector<container::NamedText> texts;
  for (const SchemeOption& option : options) {
    const auto found = values.find(option.name);
    if (option.stored == Stored::kNever || found == values.end()) continue;
    const bool is_default = !option.is_chosen && found->second == option.fallback;
    if (option.stored == Stored::kUnlessDefault && is_default) continue;
    texts.push_back({option.name, text_of(found->second)});
  }
  return texts;
}

}  // namespace colossus::pipeline::facts
