// What a build is known by when it is resumed.
#include "pipeline/run/inputs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <set>

#include "core/error.hpp"
#include "core/version.hpp"
#include "support/temporary_directory.hpp"

namespace colossus::pipeline::run {
namespace {

using facts::BuildOptions;

std::optional<core::Error> error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const core::Error& error) {
    return error;
  }
  return std::nullopt;
}

const std::vector<InputStamp> kInputs{{"/data/a.ply", 1000, 1'700'000'000'123'456'789},
                                      {"/data/b.ply", 2000, 5}};

TEST(Manifest, ChangesWithEachInput) {
  const BuildOptions options;
  const std::vector<std::function<void(std::vector<InputStamp>&)>> changes{
      [](std::vector<InputStamp>&) {},
      [](std::vector<InputStamp>& inputs) { inputs[0].path = "/data/c.ply"; },
      [](std::vector<InputStamp>& inputs) { ++inputs[1].bytes; },
      [](std::vector<InputStamp>& inputs) { ++inputs[1].modified; },
      [](std::vector<InputStamp>& inputs) { std::swap(inputs[0], inputs[1]); },
      [](std::vector<InputStamp>& inputs) { inputs.pop_back(); },
      [](std::vector<InputStamp>& inputs) { inputs.push_back(inputs[0]); }};
  std::set<std::uint64_t> keys;
  for (const auto& change : changes) {
    std::vector<InputStamp> inputs = kInputs;
    change(inputs);
    keys.insert(manifest_of(options, inputs).key());
  }
  EXPECT_EQ(keys.size(), changes.size());
}

TEST(Manifest, SaysWhatDiffersAndSurvivesItsText) {
  BuildOptions options;
  options.tolerance = 0.1;
  const scratch::Manifest one = manifest_of(options, kInputs);
  EXPECT_EQ(scratch::Manifest::parse(one.text()), one);
  options.of_scheme["color_weight"] = 2.0;
  EXPECT_NE(manifest_of(options, kInputs).difference_from(one).find("color_weight"), std::string::npos);
}

TEST(Manifest, HoldsTheProgramsRelease) {
  const scratch::Manifest manifest = manifest_of({}, kInputs);
  const std::pair<std::string, std::string> wanted{"program", core::release_version()};
  EXPECT_EQ(std::count(manifest.entries.begin(), manifest.entries.end(), wanted), 1);
}

class Inputs : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name) << text;
    return folder_.path() / name;
  }
  support::TemporaryDirectory folder_;
};

TEST_F(Inputs, AreStampedInTheirOrderAndThoseOfLists) {
  const auto a = write("a.ply", "12345");
  const auto b = write("b.ply", "123");
  const auto list = write("list.txt", "# two\nb.ply\n");
  BuildOptions options;
  options.inputs = {a.string(), "@" + list.string(), a.string()};
  const auto stamps = stamps_of_inputs(options);
  ASSERT_EQ(stamps.size(), 3U);
  EXPECT_EQ(stamps[0].path, a);
  EXPECT_EQ(stamps[1].path, b);
  EXPECT_EQ(stamps[1].bytes, 3U);
  EXPECT_EQ(stamps[2].bytes, 5U);
  EXPECT_GT(stamps[0].modified, 1'000'000'000'000'000'000);
  const auto spared = spared_inputs(options.inputs);
  std::set<std::pair<std::string, std::filesystem::path>> named;
  for (const core::SparedFile& file : spared) named.insert({file.role, file.path});
  EXPECT_EQ(named, (decltype(named){{"the input", a}, {"the input", b}, {"the list", list}}));
}

TEST_F(Inputs, ThatAreNotThereOrNoFilesAreRefused) {
  BuildOptions options;
  options.inputs = {(folder_.path() / "none.ply").string()};
  auto error = error_of([&] { stamps_of_inputs(options); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->status(), core::Status::kBadData);
  EXPECT_NE(std::string(error->what()).find("none.ply"), std::string::npos);
  options.inputs = {folder_.path().string()};
  error = error_of([&] { stamps_of_inputs(options); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->status(), core::Status::kBadData);
  EXPECT_NE(std::string(error->what()).find("expected a regular file"), std::string::npos) << error->what();
}

TEST_F(Inputs, ThatChangeAreNoticed) {
  const auto a = write("a.ply", "12345");
  BuildOptions options;
  options.inputs = {a.string()};
  const auto before = stamps_of_inputs(options);
  EXPECT_FALSE(error_of([&] { check_unchanged(before); }));
  std::vector<InputStamp> touched = before;
  ++touched[0].modified;
  write("a.ply", "123456");
  for (const auto& stamps : {before, touched}) {
    const auto error = error_of([&] { check_unchanged(stamps); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->status(), core::Status::kBadData);
    EXPECT_NE(std::string(error->what()).find("a.ply: was changed while it was read"), std::string::npos);
  }
  touched = stamps_of_inputs(options);
  ++touched[0].modified;
  EXPECT_TRUE(error_of([&] { check_unchanged(touched); })) << "by a nanosecond, at the same size";
}

}  // namespace
}  // namespace colossus::pipeline::run
