#include "pipeline/facts/scheme_options.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "pipeline/facts/option_table.hpp"

namespace colossus::pipeline::facts {
namespace {

[[noreturn]] void fail_type(const char* name, const OptionValue& found) {
  core::fail(core::Status::kUsage, "{}: {} is a value of another type", flag_of(name), text_of(found));
}

}  // namespace

std::string text_of(const OptionValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

template <typename T>
std::optional<T> value_of(const TypedOption<T>& option, const SchemeValues& values) {
  const auto found = values.find(option.name);
  if (found == values.end()) return option.fallback;
  if (!std::holds_alternative<T>(found->second)) fail_type(option.name, found->second);
  return std::get<T>(found->second);
}
template std::optional<bool> value_of(const TypedOption<bool>&, const SchemeValues&);
template std::optional<std::int64_t> value_of(const TypedOption<std::int64_t>&, const SchemeValues&);
template std::optional<double> value_of(const TypedOption<double>&, const SchemeValues&);

void complete(std::span<const SchemeOption> options, SchemeValues& values) {
  for (const SchemeOption& option : options)
    if (option.help != nullptr && option.fallback) values.try_emplace(option.name, *option.fallback);
}

void check_types(std::span<const SchemeOption> options, const SchemeValues& values) {
  for (const SchemeOption& option : options)
    if (const auto found = values.find(option.name);
        found != values.end() && found->second.index() != option.type.index())
      fail_type(option.name, found->second);
}

std::vector<container::NamedText> stored_values(std::span<const SchemeOption> options,
                                                const SchemeValues& values) {
  std::vector<container::NamedText> texts;
  for (const SchemeOption& option : options) {
    const auto found = values.find(option.name);
    const std::optional<OptionValue> value =
        found != values.end() ? std::optional(found->second) : option.fallback;
    if (option.stored == Stored::kNever || !value) continue;
    if (option.stored == Stored::kUnlessDefault && value == option.fallback) continue;
    texts.push_back({option.name, text_of(*value)});
  }
  return texts;
}

std::vector<container::NamedText> meanings_of(std::span<const SchemeOption> options) {
  std::vector<container::NamedText> meanings;
  for (const SchemeOption& option : options) meanings.push_back({option.name, option.meaning});
  return meanings;
}

}  // namespace colossus::pipeline::facts
