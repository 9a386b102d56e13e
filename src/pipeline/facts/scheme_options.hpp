// Options that one scheme has and others have not. The scheme declares them in its own folder; command line,
// manifest, container and report handle them without knowing any.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "container/schema.hpp"
#include "pipeline/facts/stored.hpp"

namespace colossus::pipeline::facts {

using OptionValue = std::variant<bool, std::int64_t, double>;

// "4", "0.5" or "true", as manifest and container have it.
std::string text_of(const OptionValue& value);

struct SchemeOption {
  const char* name;  // in manifest, container and report; see flag_of() for the command line
  const char* help;  // nullptr: tests and benchmarks have it, the program has not
  // Its type, and what holds where it is not given.
  OptionValue fallback;
  bool is_chosen = false;  // by the build where it is not given; then the fallback is its type alone
  Stored stored = Stored::kUnlessDefault;
};

// What was given, by name.
using SchemeValues = std::map<std::string, OptionValue, std::less<>>;

// The value that was given; nothing if none was. A value of another type is a bug.
template <typename T>
std::optional<T> given_value(const SchemeValues& values, std::string_view name) {
  const auto found = values.find(name);
  return found == values.end() ? std::nullopt : std::optional<T>(std::get<T>(found->second));
}

// Those that a container stores, in the order of the options.
std::vector<container::NamedText> stored_values(std::span<const SchemeOption> options,
                                                const SchemeValues& values);

}  // namespace colossus::pipeline::facts
