#include "pipeline/run/restart.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "mpi_test.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::run {
namespace {

using testing::error_of;
using testing::world;

scratch::Manifest sample_manifest() {
  scratch::Manifest manifest;
  manifest.add("leaf_triangles", "8000");
  return manifest;
}

// A folder of which all ranks know the name; removed with all that is in it. Collective.
class CommonFolder {
 public:
  CommonFolder() {
    auto pid = static_cast<std::uint64_t>(::getpid());
    broadcast_value(world(), pid);
    path_ = std::filesystem::temp_directory_path() / fmt::format("colossus-restart-{}", pid);
    if (world().is_root()) std::filesystem::create_directory(path_);
    world().barrier();
  }
  ~CommonFolder() {
    world().barrier();
    if (world().is_root()) std::filesystem::remove_all(path_);
  }
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

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

}  // namespace
}  // namespace colossus::pipeline::run
