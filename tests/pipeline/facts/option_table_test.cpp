#include "pipeline/facts/option_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <set>
#include <type_traits>

#include "core/error.hpp"
#include "pipeline/run/build_id.hpp"
#include "pipeline/run/inputs.hpp"

namespace colossus::pipeline::facts {
namespace {

void change(bool& value) { value = !value; }
void change(std::string& value) { value += "x"; }
void change(std::filesystem::path& value) { value += "x"; }
template <typename T>
void change(T& value) {
  if constexpr (std::is_arithmetic_v<T>)
    value += 1;
  else
    change(value.emplace());
}

scratch::Manifest manifest_with(const BuildOptions& options) { return run::manifest_of(options, {}); }

TEST(OptionTable, EachMemberOfTheOptionsIsALine) {
  BuildOptions options;
  // Does not compile when there is a new member: it wants a line in the table, and a name here.
  [[maybe_unused]] auto& [inputs, output, scratch, resume, time_limit, scheme, leaf_triangles, position_bits,
                          tolerance, drop_textures, is_lenient, keep_outliers, memory, status_file,
                          report_file, is_dry_run, command, codec, of_scheme] = options;
  constexpr std::size_t kMembers = 19;
  std::set<const void*> found;
  for_each_option([&](const Option&, auto member) { found.insert(&std::invoke(member, options)); });
  EXPECT_EQ(found.size(), kMembers - 2);
  EXPECT_EQ(found.count(&command), 0U) << "the words of the command line are no option";
  EXPECT_EQ(found.count(&of_scheme), 0U) << "the schemes have these";
}

TEST(OptionTable, EachThatShapesBytesIsInTheManifest) {
  const scratch::Manifest before = manifest_with({});
  for_each_shaping_option([&](const Option& option, auto member) {
    BuildOptions options;
    change(std::invoke(member, options));
    const scratch::Manifest after = manifest_with(options);
    EXPECT_NE(after, before) << option.name;
    EXPECT_NE(after.key(), before.key()) << option.name;
    EXPECT_NE(after.difference_from(before).find(option.name), std::string::npos)
        << option.name << ": " << after.difference_from(before);
  });
}

TEST(OptionTable, WhatDoesNotShapeBytesMayDifferInTheNextAttempt) {
  const scratch::Manifest before = manifest_with({});
  const auto expect_same = [&](const Option& option, auto member) {
    BuildOptions options;
    change(std::invoke(member, options));
    EXPECT_EQ(manifest_with(options), before) << option.name;
  };
  for_each_run_option(expect_same);
}

TEST(OptionTable, TheManifestHoldsTheBuild) {
  scratch::Manifest other = manifest_with({});
  auto build = std::find_if(other.entries.begin(), other.entries.end(),
                            [](const auto& entry) { return entry.first == "build"; });
  ASSERT_NE(build, other.entries.end());
  EXPECT_EQ(build->second, run::build_id());
  EXPECT_NE(build->second.find(run::build_commit()), std::string::npos);
  build->second = "commit none, sources 0";
  EXPECT_EQ(manifest_with({}).difference_from(other),
            fmt::format("build is commit none, sources 0 there, and {} here", run::build_id()));
}

TEST(OptionTable, TheContainerStoresWhatWasChosen) {
  BuildOptions options;
  options.position_bits = 9;
  options.is_lenient = true;
  using Texts = std::vector<container::NamedText>;
  EXPECT_EQ(
      stored_options(options),
      (Texts{{"leaf_triangles", "8000"}, {"position_bits", "9"}, {"codec", "predict"}, {"lenient", "true"}}));
}

constexpr TypedOption<std::int64_t> kSize{"z_size", "", ""};
constexpr TypedOption<double> kWeight{"weight", "", "What it weighs", 0.0};
constexpr TypedOption<bool> kAlways{"always", "", "", true, Stored::kAlways};
constexpr TypedOption<bool> kNever{"never", nullptr, "", true, Stored::kNever};
constexpr TypedOption<std::int64_t> kALevel{"a_level", "", ""};
constexpr std::array<SchemeOption, 5> kSample{kSize, kWeight, kAlways, kNever, kALevel};

TEST(SchemeOptions, TheManifestHoldsWhatWasGiven) {
  BuildOptions options;
  const scratch::Manifest before = manifest_with(options);
  for (const OptionValue& value : {OptionValue(true), OptionValue(std::int64_t{7}), OptionValue(0.5)}) {
    options.of_scheme["of_some_scheme"] = value;
    const scratch::Manifest after = manifest_with(options);
    EXPECT_NE(after.key(), before.key());
    EXPECT_NE(after.difference_from(before).find("of_some_scheme"), std::string::npos);
  }
}

TEST(SchemeOptions, TheContainerStoresWhatWasChosenInTheOrderOfTheScheme) {
  using Texts = std::vector<container::NamedText>;
  EXPECT_EQ(stored_values(kSample, {}), (Texts{{"always", "true"}}));
  EXPECT_EQ(stored_values(kSample, {{"a_level", std::int64_t{0}},
                                    {"z_size", std::int64_t{4}},
                                    {"weight", 0.0},
                                    {"always", false},
                                    {"never", false}}),
            (Texts{{"z_size", "4"}, {"always", "false"}, {"a_level", "0"}}));
  EXPECT_EQ(stored_values(kSample, {{"weight", 0.25}}), (Texts{{"weight", "0.25"}, {"always", "true"}}));
  EXPECT_EQ(meanings_of(kSample)[1], (container::NamedText{"weight", "What it weighs"}));
}

TEST(SchemeOptions, ItMakesNoDifferenceWhetherADefaultIsGiven) {
  BuildOptions nothing, given;
  given.of_scheme["weight"] = 0.0;
  EXPECT_NE(manifest_with(given), manifest_with(nothing));
  for (BuildOptions* options : {&nothing, &given}) complete(kSample, options->of_scheme);
  EXPECT_EQ(manifest_with(given), manifest_with(nothing));
  // What the build is to choose, and what only tests have, stay open.
  EXPECT_EQ(nothing.of_scheme, (SchemeValues{{"weight", 0.0}, {"always", true}}));
  nothing.of_scheme["weight"] = 2.0;
  complete(kSample, nothing.of_scheme);
  EXPECT_EQ(std::get<double>(nothing.of_scheme["weight"]), 2.0);
}

}  // namespace
}  // namespace colossus::pipeline::facts
