#include "core/file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace colossus::core {
namespace {

// In a process of its own: writes where no file may have more than 1000 bytes, and exits with the status.
[[noreturn]] void write_beyond_the_limit(const std::filesystem::path& path) {
  std::signal(SIGXFSZ, SIG_IGN);
  File file = File::create(path);
  const struct rlimit limit = {1000, 1000};
  if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) std::_Exit(1);
  try {
    file.write_at(0, Bytes(1000));
    file.write_at(1000, Bytes(1));
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    std::_Exit(static_cast<int>(error.status()));
  }
  std::_Exit(0);
}

TEST(File, AFullDiskAndALimitOnTheSizeAreMissingResources) {
  File full = File::create("/dev/full");
  try {
    full.write_at(0, Bytes(1));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), Status::kNoResources) << error.what();
  }
  const auto path = std::filesystem::path(testing::TempDir()) / "colossus-file-test";
  EXPECT_EXIT(write_beyond_the_limit(path), testing::ExitedWithCode(69),
              "colossus-file-test: cannot write 1 bytes at byte 1000: File too large");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace colossus::core
