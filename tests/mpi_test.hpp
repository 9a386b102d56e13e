// For tests on several ranks. Their main() is tests/mpi_main.cpp, which runs the tests on every rank; rank 0
// prints, the others print only what fails. An exception that leaves a test ends all ranks.
//
// An assertion that fails on one rank only, before a collective call, leaves the other ranks waiting: where
// the outcome can differ between ranks, use ASSERT_ALL or EXPECT_ALL.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <optional>

#include "cluster/communicator.hpp"

namespace colossus::testing {

// All ranks of the test program.
cluster::Communicator& world();

// Collective. Success if `mine` is true on every rank; else names the lowest rank where it is not.
::testing::AssertionResult holds_on_all_ranks(bool mine);

// The seed of random tests, the same on all ranks: COLOSSUS_TEST_SEED from the environment, or 1. main()
// prints it.
std::uint64_t test_seed();

// The Error that `action` throws, if any.
std::optional<core::Error> error_of(const std::function<void()>& action);

}  // namespace colossus::testing

// Collective. They fail on all ranks, or on none.
#define EXPECT_ALL(...) \
  EXPECT_TRUE(::colossus::testing::holds_on_all_ranks(static_cast<bool>(__VA_ARGS__))) << #__VA_ARGS__
#define ASSERT_ALL(...) \
  ASSERT_TRUE(::colossus::testing::holds_on_all_ranks(static_cast<bool>(__VA_ARGS__))) << #__VA_ARGS__
