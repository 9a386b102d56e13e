#include "core/error.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <new>
#include <system_error>

namespace colossus::core {
namespace {

template <typename Exception>
Status status_of(const Exception& exception) {
  try {
    throw exception;
  } catch (...) {
    return error_of_current_exception().status();
  }
}

TEST(ErrorOfCurrentException, TellsTheMachinesFaultFromOurs) {
  const auto system = [](std::errc code) { return std::system_error(std::make_error_code(code)); };
  const auto file = [](std::errc code) {
    return std::filesystem::filesystem_error("cannot rename", "a", "b", std::make_error_code(code));
  };
  EXPECT_EQ(status_of(Error(Status::kStopped, "stop")), Status::kStopped);
  EXPECT_EQ(status_of(std::bad_alloc()), Status::kNoResources);
  EXPECT_EQ(status_of(std::length_error("vector")), Status::kNoResources);
  EXPECT_EQ(status_of(system(std::errc::resource_unavailable_try_again)), Status::kNoResources);
  EXPECT_EQ(status_of(file(std::errc::no_space_on_device)), Status::kNoResources);
  EXPECT_EQ(status_of(file(std::errc::is_a_directory)), Status::kIo);
  EXPECT_EQ(status_of(std::logic_error("ours")), Status::kInternal);
  EXPECT_EQ(status_of(7), Status::kInternal);
}

}  // namespace
}  // namespace colossus::core
