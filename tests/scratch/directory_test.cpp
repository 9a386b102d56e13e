#include "scratch/directory.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/error.hpp"
#include "scratch/spool.hpp"
#include "temporary_directory.hpp"

namespace colossus::scratch {
namespace {

template <typename Action>
core::Status status_of(const Action& action, std::string* message = nullptr) {
  try {
    action();
  } catch (const core::Error& error) {
    if (message) *message = error.what();
    return error.status();
  }
  return core::Status::kOk;
}

TEST(ScratchDirectory, IsCreatedExclusivelyAndTheMessageSaysWhatToDo) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "statue.h5.scratch";
  const ScratchDirectory first = ScratchDirectory::create(path);
  std::string message;
  EXPECT_EQ(status_of([&] { ScratchDirectory::create(path); }, &message), core::Status::kCannotCreate);
  EXPECT_NE(message.find(path.string()), std::string::npos) << message;
  EXPECT_NE(message.find("remove it"), std::string::npos) << message;
  EXPECT_TRUE(std::filesystem::exists(path)) << "the failed attempt removed the other's directory";
}

TEST(ScratchDirectory, CannotBeCreatedInADirectoryThatIsMissing) {
  const TemporaryDirectory parent;
  EXPECT_EQ(status_of([&] { ScratchDirectory::create(parent.path() / "none" / "scratch"); }),
            core::Status::kCannotCreate);
}

TEST(ScratchDirectory, OpenNeedsADirectory) {
  const TemporaryDirectory parent;
  EXPECT_EQ(status_of([&] { ScratchDirectory::open(parent.path() / "none"); }), core::Status::kIo);
  EXPECT_EQ(ScratchDirectory::open(parent.path()).path(), parent.path());
  EXPECT_TRUE(std::filesystem::exists(parent.path())) << "who opens a directory must not remove it";
}

TEST(ScratchDirectory, RemovesItselfWithItsSpools) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "scratch";
  ScratchDirectory directory = ScratchDirectory::create(path);
  SpoolWriter(path, 0);
  SpoolWriter(path, 1'234'567);
  EXPECT_TRUE(std::filesystem::exists(directory.spool_path(1'234'567)));
  directory.remove();
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(ScratchDirectory, IsRemovedWhenItsOwnerIsDestroyedUnlessKept) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "scratch";
  {
    const ScratchDirectory first = ScratchDirectory::create(path);
    SpoolWriter(path, 3);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  {
    ScratchDirectory second = ScratchDirectory::create(path);
    ScratchDirectory moved = std::move(second);
    moved.keep();
  }
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(ScratchDirectory, NeverRemovesFilesThatAreNotItsOwn) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "scratch";
  for (const char* name : {"notes.txt", "rank-.spool", "rank-1x.spool", "rank-000001.spool.bak"}) {
    ScratchDirectory directory = ScratchDirectory::create(path);
    SpoolWriter(path, 3);
    std::ofstream(path / name) << "precious";
    EXPECT_EQ(status_of([&] { directory.remove(); }), core::Status::kIo);
    EXPECT_TRUE(std::filesystem::exists(path / name)) << name;
    EXPECT_FALSE(std::filesystem::exists(directory.spool_path(3)));
    std::filesystem::remove_all(path);
  }
}

}  // namespace
}  // namespace colossus::scratch
