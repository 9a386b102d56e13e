#include "pipeline/run/restart.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "pipeline/test_build.hpp"

namespace colossus::pipeline::run {
namespace {

// What a rank of another host has under the name of the scratch directory, where it is not the same one.
std::string error_of_seeing(const std::filesystem::path& directory, const std::filesystem::path& elsewhere) {
  const auto error = error_of(
      [&] { open_scratch(world(), world().is_root() ? directory : elsewhere, false, sample_manifest()); });
  EXPECT_ALL(error && error->status() == core::Status::kIo);
  EXPECT_ALL(!std::filesystem::exists(directory));
  return error ? error->what() : "";
}

TEST(OpenScratch, GivesAllRanksTheFolderOfTheAttempt) {
  const CommonFolder folder;
  for (std::uint16_t attempt = 1; attempt <= 3; ++attempt) {
    const OpenedScratch opened = open_scratch(world(), folder / "scratch", attempt > 1, sample_manifest());
    EXPECT_EQ(opened.location.folder, scratch::folder_of_attempt(folder / "scratch", attempt));
    EXPECT_EQ(opened.progress.journal.attempt(), attempt);
    EXPECT_EQ(opened.progress.is_resumed, attempt > 1);
  }
}

TEST(OpenScratch, RefusesADirectoryThatARankDoesNotSee) {
  if (world().size() == 1) GTEST_SKIP() << "needs two ranks";
  const CommonFolder folder;
  const std::string message = error_of_seeing(folder / "scratch", folder / "elsewhere");
  EXPECT_NE(message.find("rank 1 on "), std::string::npos) << message;
  EXPECT_NE(message.find("choose one on a file system that all hosts share with --scratch"),
            std::string::npos)
      << message;
}

TEST(OpenScratch, RefusesADirectoryOfTheSameNameOnAnotherFileSystem) {
  if (world().size() == 1) GTEST_SKIP() << "needs two ranks";
  const CommonFolder folder;
  const auto elsewhere = folder / "elsewhere";
  if (world().is_root()) {
    // As far as the same build could have come there.
    scratch::create_scratch_directory(elsewhere);
    const auto there = scratch::folder_of_attempt(elsewhere, 1);
    scratch::write_manifest(there, sample_manifest());
    scratch::JournalWriter({there, sample_manifest().key()}, 1, 0).append_start({12345, {}});
  }
  world().barrier();
  const std::string message = error_of_seeing(folder / "scratch", elsewhere);
  EXPECT_NE(message.find("rank 1 on "), std::string::npos) << message;
}

// Lets rank 0 prepare the folder, then has all open the scratch directory in it.
std::optional<core::Error> error_of_opening(
    const CommonFolder& folder, bool may_resume,
    const std::function<void(const std::filesystem::path&)>& prepare) {
  const std::filesystem::path directory = folder / "scratch";
  if (world().is_root()) prepare(directory);
  world().barrier();
  return error_of([&] { open_scratch(world(), directory, may_resume, sample_manifest()); });
}

void write_file(const std::filesystem::path& path) { std::ofstream(path) << "mine"; }

TEST(OpenScratch, RefusesWhatIsThereUnlessItMayResume) {
  const CommonFolder folder;
  open_scratch(world(), folder / "scratch", false, sample_manifest());
  const auto error = error_of_opening(folder, false, [](const auto&) {});
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kCannotCreate);
  EXPECT_NE(std::string(error->what()).find("--resume"), std::string::npos);
  EXPECT_EQ(scratch::look_into_directory(folder / "scratch").attempt, 1) << "it stays as it was";
}

TEST(OpenScratch, LeavesFoldersOfOthersAlone) {
  for (const bool may_resume : {false, true}) {
    const CommonFolder folder;
    const auto error = error_of_opening(folder, may_resume, [](const auto& directory) {
      std::filesystem::create_directory(directory);
      write_file(directory / "a-file");
    });
    ASSERT_ALL(error.has_value());
    EXPECT_EQ(error->status(), core::Status::kCannotCreate);
    EXPECT_TRUE(std::filesystem::exists(folder / "scratch" / "a-file"));
  }
}

TEST(OpenScratch, RefusesForeignFilesInTheFolderOfTheAttempt) {
  const CommonFolder folder;
  open_scratch(world(), folder / "scratch", false, sample_manifest());
  const auto error = error_of_opening(folder, true, [](const auto& directory) {
    write_file(scratch::folder_of_attempt(directory, 1) / "a-file");
  });
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kCannotCreate);
  EXPECT_EQ(scratch::look_into_directory(folder / "scratch").attempt, 1);
}

TEST(OpenScratch, RefusesAnotherBuildAndSaysWhatDiffers) {
  const CommonFolder folder;
  open_scratch(world(), folder / "scratch", false, sample_manifest());
  scratch::Manifest other;
  other.add("leaf_triangles", "1500");
  const auto error = error_of([&] { open_scratch(world(), folder / "scratch", true, other); });
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kUsage);
  EXPECT_NE(std::string(error->what()).find("leaf_triangles is 8000 there, and 1500 here"), std::string::npos)
      << error->what();
  EXPECT_FALSE(error_of([&] { open_scratch(world(), folder / "scratch", true, sample_manifest()); }));
}

TEST(OpenScratch, RefusesADamagedManifestWhereThereIsWork) {
  const CommonFolder folder;
  open_scratch(world(), folder / "scratch", false, sample_manifest());
  const auto error = error_of_opening(folder, true, [](const auto& directory) {
    const auto attempt = scratch::folder_of_attempt(directory, 1);
    scratch::remove_manifest(attempt);
  });
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kCannotCreate);
  EXPECT_NE(std::string(error->what()).find("manifest"), std::string::npos);
}

// Killed before its manifest was complete.
TEST(OpenScratch, BeginsAnewWhereAnAttemptHasNotBegun) {
  const CommonFolder folder;
  EXPECT_FALSE(error_of_opening(folder, true,
                                [](const auto& directory) { scratch::create_scratch_directory(directory); }));
  const auto content = scratch::look_into_directory(folder / "scratch");
  EXPECT_EQ(content.attempt, 2);
  EXPECT_EQ(scratch::read_manifest(scratch::folder_of_attempt(folder / "scratch", 2)), sample_manifest());
}

TEST(OpenScratch, UsesAnEmptyFolderThatStays) {
  for (const bool is_own_name : {false, true}) {
    const CommonFolder folder;
    const std::filesystem::path directory = folder / "scratch";
    if (world().is_root()) std::filesystem::create_directory(directory);
    world().barrier();
    const OpenedScratch opened = open_scratch(world(), directory, true, sample_manifest(), is_own_name);
    EXPECT_EQ(opened.progress.journal.attempt(), 1);
    world().barrier();
    if (world().is_root()) scratch::remove_scratch_directory(directory, 1);
    world().barrier();
    EXPECT_EQ(std::filesystem::exists(directory), !is_own_name) << "what a killed build has left goes";
  }
}

}  // namespace
}  // namespace colossus::pipeline::run
