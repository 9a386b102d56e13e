#include "cluster/farm.hpp"

#include <algorithm>
#include <random>
#include <stdexcept>

#include "core/hash.hpp"
#include "mpi_test.hpp"

namespace colossus::cluster {
namespace {

using core::Bytes;
using testing::world;

constexpr std::size_t kLongest = 300'000;  // far above the size up to which MPI sends without being received

// Bytes that depend on the task and the seed, of a size that does too.
Bytes random_bytes(std::uint64_t seed, std::size_t longest) {
  std::mt19937_64 random(core::mix64(seed + testing::test_seed() * 1'000'003));
  Bytes bytes(random() % 4 == 0 ? 0 : random() % longest);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

Bytes task_bytes(std::size_t task, std::size_t longest) {
  core::ByteWriter writer;
  writer.put<std::uint64_t>(task);
  writer.put_bytes(random_bytes(2 * task, longest));
  return writer.take();
}

// The task's number, and a result that only the right task bytes give.
Bytes result_for(std::span<const std::byte> task, std::size_t longest) {
  const auto number = core::ByteReader(task).get<std::uint64_t>();
  core::ByteWriter writer;
  writer.put<std::uint64_t>(core::hash64(task));
  writer.put_bytes(random_bytes(2 * number + 1, longest));
  return writer.take();
}

std::uint64_t number_of(std::span<const std::byte> task) {
  return core::ByteReader(task).get<std::uint64_t>();
}

// Runs `count` tasks and checks on rank 0 that each result came once and is right, and that tasks were made
// in order.
void expect_complete(std::size_t count, std::size_t longest) {
  std::vector<int> seen(count);
  std::size_t made = 0;
  bool good = true;
  const auto make_task = [&](std::size_t task) {
    good = good && task == made++;
    return task_bytes(task, longest);
  };
  const auto on_result = [&](std::size_t task, Bytes result) {
    good =
        good && task < count && ++seen[task] == 1 && result == result_for(task_bytes(task, longest), longest);
  };
  // Only rank 0 knows the number of tasks.
  const FarmShare share = run_farm(
      world(), world().is_root() ? count : 0, make_task,
      [&](std::span<const std::byte> task) { return result_for(task, longest); }, on_result);
  if (world().is_root())
    good = good && made == count && std::count(seen.begin(), seen.end(), 1) == std::ssize(seen);
  EXPECT_ALL(good) << count << " tasks";
  EXPECT_ALL(world().sum<std::uint64_t>(share.task_count) ==
             world().max<std::uint64_t>(world().is_root() ? count : 0));
  EXPECT_ALL(share.work_seconds <= share.total_seconds);
}

TEST(Farm, RunsEachTaskOnceForAnyNumberOfTasks) {
  for (const std::size_t count : {0, 1, 2, 3, 5, 8, 13, 14, 15, 200}) expect_complete(count, 100);
}

TEST(Farm, RunsRandomNumbersOfTasksWithLargeTasksAndResults) {
  std::mt19937_64 random(testing::test_seed());
  for (int round = 0; round < 6; ++round) expect_complete(random() % 40, kLongest);
}

TEST(Farm, SplitsMessagesIntoPieces) {
  world().set_piece_bytes(1000);
  expect_complete(30, 20'000);
  world().set_piece_bytes(kDefaultPieceBytes);
}

TEST(Farm, ManyFarmsInARowDoNotMixTheirMessages) {
  for (int round = 0; round < 50; ++round) expect_complete(static_cast<std::size_t>(round % 4), 10);
}

TEST(Farm, MakesTasksLazily) {
  // A worker holds at most two tasks, so no more may have been made than results have come, plus two per
  // worker.
  const std::size_t most_held = world().size() == 1 ? 1 : 2 * static_cast<std::size_t>(world().size() - 1);
  std::size_t made = 0;
  std::size_t taken = 0;
  bool good = true;
  run_farm(
      world(), 100,
      [&](std::size_t) {
        ++made;
        good = good &&
               made <= taken + most_held + 1;  // the next task leaves before its predecessor's result is used
        return Bytes(8);
      },
      [](std::span<const std::byte>) { return Bytes(); }, [&](std::size_t, Bytes) { ++taken; });
  EXPECT_ALL(good);
}

// Runs `count` tasks of which the ones in `bad` throw; returns the error of this rank.
template <typename Exception>
std::optional<core::Error> failing_farm(std::size_t count, const std::vector<std::size_t>& bad,
                                        const Exception& exception) {
  return testing::error_of([&] {
    run_farm(
        world(), count, [](std::size_t task) { return task_bytes(task, kLongest); },
        [&](std::span<const std::byte> task) {
          if (std::find(bad.begin(), bad.end(), number_of(task)) != bad.end()) throw exception;
          return result_for(task, kLongest);
        },
        [](std::size_t, Bytes) {});
  });
}

// All ranks must have the same error.
void expect_same_error(const std::optional<core::Error>& error, core::Status status,
                       const std::string& start) {
  ASSERT_ALL(error.has_value());
  EXPECT_ALL(error->status() == status) << error->what();
  const std::string message = error->what();
  EXPECT_ALL(message.substr(0, start.size()) == start) << message;
  for (const Bytes& other : world().all_gather(core::as_bytes(std::span<const char>(message))))
    EXPECT_ALL(other.size() == message.size() &&
               std::equal(message.begin(), message.end(), other.begin(),
                          [](char a, std::byte b) { return std::byte(a) == b; }));
}

TEST(Farm, AFailingTaskIsTheSameErrorOnAllRanksAndTheNextFarmWorks) {
  for (const std::size_t bad : {0, 1, 7, 19}) {
    const auto error = failing_farm(20, {bad}, core::Error(core::Status::kBadData, "node is bad"));
    expect_same_error(error, core::Status::kBadData, fmt::format("node is bad (task {} on rank ", bad));
    expect_complete(9, kLongest);
  }
}

TEST(Farm, AllTasksMayFail) {
  std::vector<std::size_t> all(20);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  // Task 0 runs in any case, and the lowest task's failure is the one that is reported.
  const auto error = failing_farm(20, all, core::Error(core::Status::kIo, "disk"));
  expect_same_error(error, core::Status::kIo, "disk (task ");
  expect_complete(5, 100);
}

TEST(Farm, AnExceptionThatIsNoErrorIsAnInternalError) {
  const auto error = failing_farm(10, {3}, std::runtime_error("surprise"));
  expect_same_error(error, core::Status::kInternal,
                    "internal error (please report it): surprise (task 3 on rank ");
}

TEST(Farm, NoTaskStartsAfterTheFailureIsKnown) {
  // Task 0 fails at once. Whatever was handed out by then may run, but not all the others.
  std::uint64_t started = 0;
  const auto error = testing::error_of([&] {
    run_farm(
        world(), 10'000, [](std::size_t task) { return task_bytes(task, 1); },
        [&](std::span<const std::byte> task) -> Bytes {
          ++started;
          if (number_of(task) == 0) throw core::Error(core::Status::kIo, "first");
          return {};
        },
        [](std::size_t, Bytes) {});
  });
  expect_same_error(error, core::Status::kIo, "first (task 0 on rank ");
  EXPECT_ALL(world().sum(started) < 10'000);
}

TEST(Farm, FailuresOfRankZerosCallbacksAreErrorsOfAllRanks) {
  const auto work = [](std::span<const std::byte> task) { return result_for(task, kLongest); };
  const auto made = testing::error_of([&] {
    run_farm(
        world(), 10,
        [](std::size_t task) {
          if (task == 4) throw core::Error(core::Status::kNoResources, "cannot make");
          return task_bytes(task, kLongest);
        },
        work, [](std::size_t, Bytes) {});
  });
  expect_same_error(made, core::Status::kNoResources, "cannot make (task 4 on rank 0)");
  const auto taken = testing::error_of([&] {
    run_farm(
        world(), 10, [](std::size_t task) { return task_bytes(task, kLongest); }, work,
        [](std::size_t task, Bytes) {
          if (task == 6) throw core::Error(core::Status::kIo, "cannot take");
        });
  });
  expect_same_error(taken, core::Status::kIo, "cannot take (task 6 on rank 0)");
  const auto first = testing::error_of([&] {
    run_farm(
        world(), 10, [](std::size_t) -> Bytes { throw core::Error(core::Status::kIo, "none"); }, work,
        [](std::size_t, Bytes) {});
  });
  expect_same_error(first, core::Status::kIo, "none (task 0 on rank 0)");
  expect_complete(10, kLongest);
}

}  // namespace
}  // namespace colossus::cluster
