#include "pipeline/facts/option_table.hpp"

#include <algorithm>
#include <functional>
#include <string_view>

#include "core/error.hpp"

namespace colossus::pipeline::facts {
namespace {

std::string text_of(const std::string& value) { return value; }

template <typename T>
std::string text_of(const T& value) {
  return fmt::format("{}", value);  // of a bool: true or false
}

template <typename Member>
bool is_default(const BuildOptions& options, Member member) {
  return std::invoke(member, options) == std::invoke(member, BuildOptions{});
}

}  // namespace

std::string flag_of(std::string_view name) {
  std::string flag = fmt::format("--{}", name);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

std::vector<container::NamedText> shaping_options(const BuildOptions& options) {
  std::vector<container::NamedText> texts;
  for_each_shaping_option([&](const Option& option, auto member) {
    if (const auto* value = given(std::invoke(member, options)))
      texts.push_back({option.name, text_of(*value)});
  });
  for (const auto& [name, value] : options.of_scheme) texts.push_back({name, text_of(value)});
  return texts;
}

std::vector<container::NamedText> stored_options(const BuildOptions& chosen) {
  std::vector<container::NamedText> texts;
  for_each_shaping_option([&](const Option& option, auto member) {
    if (option.stored == Stored::kNever) return;
    if (option.stored == Stored::kUnlessDefault && is_default(chosen, member)) return;
    if (const auto* value = given(std::invoke(member, chosen)))
      texts.push_back({option.name, text_of(*value)});
  });
  return texts;
}

}  // namespace colossus::pipeline::facts
