#include "pipeline/schemes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "core/error.hpp"
#include "hierarchy/octree.hpp"
#include "pipeline/build.hpp"
#include "pipeline/facts/option_table.hpp"

namespace colossus::pipeline {
namespace {

using facts::BuildOptions;
using Change = std::function<void(BuildOptions&)>;

// Whether the scheme takes the options; else the message names `option`.
bool takes(const char* scheme, const Change& change, const std::string& option) {
  BuildOptions options;
  options.scheme = scheme;
  change(options);
  try {
    check_options(options);
    return true;
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kUsage);
    EXPECT_EQ(std::string(error.what()).find(option), 0U) << error.what();
    return false;
  }
}

TEST(Schemes, AreFoundByTheirNamesTheDefaultFirst) {
  std::set<std::string> names;
  for (const nodes::Scheme* scheme : schemes()) {
    EXPECT_EQ(&scheme_named(scheme->name), scheme);
    names.insert(scheme->name);
  }
  EXPECT_EQ(names.size(), schemes().size());
  EXPECT_EQ(&scheme_named(BuildOptions{}.scheme), schemes()[0]);
}

TEST(Schemes, ThatAreUnknownAreRefusedWithThoseThatAreNot) {
  for (const char* name : {" ", "diamond", "Diamonds", "cubes"}) {
    try {
      scheme_named(name);
      ADD_FAILURE() << name;
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), core::Status::kUsage);
      for (const nodes::Scheme* scheme : schemes())
        EXPECT_NE(std::string(error.what()).find(scheme->name), std::string::npos);
    }
  }
}

TEST(Schemes, TakePositionBitsWithinTheirRange) {
  for (const nodes::Scheme* scheme : schemes())
    for (int bits = -1; bits < 40; ++bits)
      EXPECT_EQ(takes(
                    scheme->name, [&](BuildOptions& o) { o.position_bits = bits; }, "--position-bits"),
                bits >= codec::coded::kMinPositionBits && bits <= codec::coded::kMaxPositionBits)
          << scheme->name << " " << bits;
}

TEST(Blocks, TakeTheirOptionsWithinTheirRanges) {
  const auto blocks = hierarchy::kBlocks;
  EXPECT_TRUE(takes(
      blocks, [](BuildOptions&) {}, ""));
  for (int levels = -2; levels < 20; ++levels)
    EXPECT_EQ(takes(
                  blocks, [&](BuildOptions& o) { o.of_scheme["levels"] = std::int64_t{levels}; }, "--levels"),
              levels >= 0 && levels <= 14);
  for (int size = -4; size < 100; ++size)
    EXPECT_EQ(
        takes(
            blocks, [&](BuildOptions& o) { o.of_scheme["block_size"] = std::int64_t{size}; }, "--block-size"),
        size % 4 == 0 && size >= hierarchy::kLeastBlockSize && size <= hierarchy::kGreatestBlockSize)
        << size;
  for (const double weight : {0.0, 0.5, 1e6})
    EXPECT_TRUE(takes(
        blocks, [&](BuildOptions& o) { o.of_scheme["color_weight"] = weight; }, ""));
  for (const double weight : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_FALSE(takes(
        blocks, [&](BuildOptions& o) { o.of_scheme["color_weight"] = weight; }, "--color-weight"));
}

// A value that is not the default.
facts::OptionValue another(const facts::SchemeOption& option) {
  facts::OptionValue value = option.fallback.value_or(option.type);
  std::visit([](auto& v) { v = static_cast<std::remove_reference_t<decltype(v)>>(!v); }, value);
  return value;
}

TEST(Schemes, OptionsOfAnotherSchemeAreRefused) {
  for (const nodes::Scheme* owner : schemes())
    for (const facts::SchemeOption& option : owner->options)
      for (const nodes::Scheme* scheme : schemes()) {
        BuildOptions options;
        options.scheme = scheme->name;
        options.of_scheme[option.name] = another(option);
        if (scheme == owner) {
          EXPECT_NO_THROW(refuse_options_of_other_schemes(options)) << option.name;
          continue;
        }
        try {
          refuse_options_of_other_schemes(options);
          ADD_FAILURE() << option.name;
        } catch (const core::Error& error) {
          EXPECT_EQ(error.status(), core::Status::kUsage);
          EXPECT_EQ(std::string(error.what()), fmt::format("{} is an option of --scheme {} only",
                                                           facts::flag_of(option.name), owner->name));
        }
        // Its default asks for nothing.
        if (!option.fallback) continue;
        options.of_scheme[option.name] = *option.fallback;
        EXPECT_NO_THROW(refuse_options_of_other_schemes(options)) << option.name;
      }
}

TEST(Schemes, OptionsThatNobodyHasAndValuesOfAnotherTypeAreRefused) {
  const auto message_of = [](const char* name, const facts::OptionValue& value) -> std::string {
    BuildOptions options;
    options.scheme = hierarchy::kBlocks;
    options.of_scheme[name] = value;
    try {
      check_options(options);
      return "";
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), core::Status::kUsage);
      return error.what();
    }
  };
  EXPECT_EQ(message_of("colour_weight", 1.0), "--colour-weight is no option");
  EXPECT_EQ(message_of("color_weight", 1.0), "");
  EXPECT_EQ(message_of("color_weight", std::int64_t{1}), "--color-weight: 1 is a value of another type");
  EXPECT_EQ(message_of("levels", 1.5), "--levels: 1.5 is a value of another type");
}

TEST(Schemes, OptionsHaveNamesThatNoCommonOneHasAndOneTypeEach) {
  std::map<std::string, std::size_t> types;
  facts::for_each_option([&](const facts::Option& option, auto) { types[option.name] = ~std::size_t{0}; });
  for (const nodes::Scheme* scheme : schemes())
    for (const facts::SchemeOption& option : scheme->options)
      EXPECT_EQ(types.try_emplace(option.name, option.type.index()).first->second, option.type.index())
          << option.name;
}

}  // namespace
}  // namespace colossus::pipeline
