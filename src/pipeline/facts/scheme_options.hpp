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

// An option with values of one type: bool, std::int64_t or double.
template <typename T>
struct TypedOption {
  const char* name;                // in manifest, container and report; see flag_of() for the command line
  const char* help;                // nullptr: tests and benchmarks have it, the program has not
  const char* meaning;             // of the stored value, for who looks into a container
  std::optional<T> fallback = {};  // what holds where it is not given; none: the build chooses
  Stored stored = Stored::kUnlessDefault;
};

// The same for tables of options. `type` is a value of its type and says nothing else.
struct SchemeOption {
  const char* name;
  const char* help;
  const char* meaning;
  OptionValue type;
  std::optional<OptionValue> fallback;
  Stored stored;

  template <typename T>
  constexpr SchemeOption(const TypedOption<T>& option)  // NOLINT: tables are made of typed ones
      : name(option.name),
        help(option.help),
        meaning(option.meaning),
        type(T{}),
        fallback(option.fallback ? std::optional<OptionValue>(*option.fallback) : std::nullopt),
        stored(option.stored) {}
};

// What was given, by name; once a build has begun also what holds where nothing was, see complete().
using SchemeValues = std::map<std::string, OptionValue, std::less<>>;

// The value that was given, or else the option's own; nothing if the build is to choose. Throws
// Error(kUsage) for a value of another type.
template <typename T>
std::optional<T> value_of(const TypedOption<T>& option, const SchemeValues& values);

// Adds those that hold where nothing was given, so that it makes no difference for the manifest whether a
// user gives them. Hidden ones are left out.
void complete(std::span<const SchemeOption> options, SchemeValues& values);

// Throws Error(kUsage) when a value is of another type than its option. Others than these are not looked at.
void check_types(std::span<const SchemeOption> options, const SchemeValues& values);

// Those that a container stores, in the order of the options; and what they mean.
std::vector<container::NamedText> stored_values(std::span<const SchemeOption> options,
                                                const SchemeValues& values);
std::vector<container::NamedText> meanings_of(std::span<const SchemeOption> options);

}  // namespace colossus::pipeline::facts
