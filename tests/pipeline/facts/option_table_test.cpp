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
  constexpr std::array<SchemeOption, 5> kOptions{{{"z_size", "", std::int64_t{4}, true},
                                                  {"weight", "", 0.0},
                                                  {"always", "", true, false, Stored::kAlways},
                                                  {"never", "", true, false, Stored::kNever},
                                                  {"a_level", "", std::int64_t{0}, true}}};
  using Texts = std::vector<container::NamedText>;
  EXPECT_EQ(stored_values(kOptions, {}), Texts{});
  EXPECT_EQ(stored_values(kOptions, {{"a_level", std::int64_t{0}},
                                     {"z_size", std::int64_t{4}},
                                     {"weight", 0.0},
                                     {"always", true},
                                     {"never", false}}),
            (Texts{{"z_size", "4"}, {"always", "true"}, {"a_level", "0"}}));
  EXPECT_EQ(stored_values(kOptions, {{"weight", 0.25}}), (Texts{{"weight", "0.25"}}));
}

}  // namespace
}  // namespace colossus::pipeline::facts
