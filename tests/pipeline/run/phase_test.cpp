// Phases, and what a resumed build does of them again, on any number of ranks.
#include "pipeline/run/phase.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "pipeline/run/progress.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::run {
namespace {

constexpr std::size_t kTasks = 23;
constexpr std::uint32_t kKind = 77;

core::Bytes bytes_of(std::uint64_t value) {
  core::ByteWriter writer;
  writer.put(value);
  return writer.take();
}
std::uint64_t value_of(std::span<const std::byte> bytes) {
  return core::ByteReader(bytes).get<std::uint64_t>();
}

// What a phase has come to: on rank 0 the records of its tasks; on all ranks how often each was worked on.
struct Outcome {
  std::vector<scratch::RecordRef> records;
  std::vector<std::uint64_t> worked;
  std::optional<core::Error> error;
  std::uint64_t work_count() const {
    std::uint64_t sum = 0;
    for (const auto count : worked) sum += count;
    return sum;
  }
};

// Task i is made of 1000 * i + salts[i], and writes its square to scratch. Fails at `failing`.
Outcome run(const Workspace& workspace, const std::string& name, const std::vector<std::uint64_t>& salts,
            std::size_t failing = kTasks) {
  Outcome outcome{
      std::vector<scratch::RecordRef>(salts.size()), std::vector<std::uint64_t>(salts.size()), {}};
  std::vector<int> taken(salts.size());
  outcome.error = error_of([&] {
    run_phase(
        workspace, name, salts.size(), [&](std::size_t i) { return bytes_of(1000 * i + salts[i]); },
        [&](std::span<const std::byte> task) {
          const std::uint64_t value = value_of(task);
          ++outcome.worked.at(value / 1000);
          if (value / 1000 == failing) core::fail(core::Status::kNoResources, "as it was told to");
          core::ByteWriter writer;
          writer.put(workspace.writer.append(kKind, bytes_of(value * value)));
          return writer.take();
        },
        [&](std::size_t i, const core::Bytes& result) {
          outcome.records[i] = core::ByteReader(result).get<scratch::RecordRef>();
          ++taken[i];
        });
  });
  world().all_sum(outcome.worked);
  if (!outcome.error && world().is_root()) {
    EXPECT_EQ(taken, std::vector<int>(salts.size(), 1));
  }
  return outcome;
}

void expect_results(const Workspace& workspace, const Outcome& outcome,
                    const std::vector<std::uint64_t>& salts) {
  if (!world().is_root()) return;
  for (std::size_t i = 0; i < salts.size(); ++i)
    EXPECT_EQ(value_of(workspace.reader.read(outcome.records[i])),
              (1000 * i + salts[i]) * (1000 * i + salts[i]));
}

const std::vector<std::uint64_t> kSalts(kTasks, 5);

TEST(Phase, RunsEachTaskOnceAndKeepsWhatItWrites) {
  const CommonFolder folder;
  const TestBuild build(folder);
  EXPECT_EQ(last_phase(build.workspace()), 0U);
  const Outcome outcome = run(build.workspace(), "squares", kSalts);
  EXPECT_EQ(outcome.worked, std::vector<std::uint64_t>(kTasks, 1));
  expect_results(build.workspace(), outcome, kSalts);
  EXPECT_EQ(last_phase(build.workspace()), 1U);
  EXPECT_EQ(run(build.workspace(), "nothing", {}).work_count(), 0U);
  EXPECT_EQ(last_phase(build.workspace()), 2U);
}

TEST(Phase, OfAFinishedAttemptIsNotDoneAgain) {
  const CommonFolder folder;
  {
    const TestBuild build(folder);
    run(build.workspace(), "squares", kSalts);
  }
  const TestBuild build(folder, {}, true);
  const Outcome outcome = run(build.workspace(), "squares", kSalts);
  EXPECT_EQ(outcome.work_count(), 0U);
  expect_results(build.workspace(), outcome, kSalts);
}

TEST(Phase, GoesOnWhereAnAttemptHasFailed) {
  const CommonFolder folder;
  std::vector<std::uint64_t> worked;
  {
    const TestBuild build(folder);
    run(build.workspace(), "first", kSalts);
    const Outcome outcome = run(build.workspace(), "second", kSalts, 11);
    ASSERT_ALL(outcome.error.has_value());
    EXPECT_EQ(outcome.error->status(), core::Status::kNoResources);
    worked = outcome.worked;
  }
  const TestBuild build(folder, {}, true);
  EXPECT_EQ(run(build.workspace(), "first", kSalts).work_count(), 0U);
  const Outcome outcome = run(build.workspace(), "second", kSalts);
  for (std::size_t i = 0; i < kTasks; ++i)
    EXPECT_EQ(outcome.worked[i], i == 11 ? 1 : 1 - worked[i]) << "what was finished is not done again: " << i;
  expect_results(build.workspace(), outcome, kSalts);
}

TEST(Phase, DoesTasksAgainThatAreMadeOfSomethingElse) {
  const CommonFolder folder;
  {
    const TestBuild build(folder);
    run(build.workspace(), "squares", kSalts);
  }
  std::vector<std::uint64_t> salts = kSalts;
  salts[3] = 6;
  salts[22] = 7;
  const TestBuild build(folder, {}, true);
  const Outcome outcome = run(build.workspace(), "squares", salts);
  EXPECT_EQ(outcome.work_count(), 2U);
  EXPECT_EQ(outcome.worked[3] + outcome.worked[22], 2U);
  expect_results(build.workspace(), outcome, salts);
}

TEST(Phase, OfAnotherNameIsDoneAgain) {
  const CommonFolder folder;
  {
    const TestBuild build(folder);
    run(build.workspace(), "squares", kSalts);
  }
  const TestBuild build(folder, {}, true);
  EXPECT_EQ(run(build.workspace(), "cubes", kSalts).work_count(), kTasks);
}

TEST(Phase, DoesTasksAgainWhoseRecordsAreDamaged) {
  const CommonFolder folder;
  std::vector<scratch::RecordRef> records;
  std::filesystem::path scratch;
  {
    const TestBuild build(folder);
    records = run(build.workspace(), "squares", kSalts).records;
    scratch = build.workspace().scratch.folder;
  }
  broadcast_values(world(), records);
  for (const std::size_t i : {2, 17})
    if (world().is_root()) {
      std::fstream file(path_of(scratch, records[i].file), std::ios::binary | std::ios::in | std::ios::out);
      file.seekp(static_cast<std::streamoff>(records[i].offset));
      file.put('\x55');
    }
  world().barrier();
  const TestBuild build(folder, {}, true);
  const Outcome outcome = run(build.workspace(), "squares", kSalts);
  EXPECT_EQ(outcome.work_count(), 2U);
  EXPECT_EQ(outcome.worked[2] + outcome.worked[17], 2U);
  expect_results(build.workspace(), outcome, kSalts);
}

std::set<int> streams_in(const std::filesystem::path& folder) {
  std::set<int> streams;
  for (const scratch::FileId& file : scratch::look_into(folder).files)
    if (file.stream != scratch::kJournalStream) streams.insert(file.stream);
  return streams;
}

TEST(Phase, IsReleasedWithItsFilesAndNotDoneAgainForIt) {
  const CommonFolder folder;
  std::filesystem::path scratch;
  {
    const TestBuild build(folder);
    for (const std::string name : {"first", "second", "third"}) run(build.workspace(), name, kSalts);
    scratch = build.workspace().scratch.folder;
    world().barrier();
    EXPECT_EQ(streams_in(scratch), (std::set<int>{1, 2, 3}));
    world().barrier();
    release_phases_up_to(build.workspace(), 1);
    release_phases_up_to(build.workspace(), 1);  // nothing is left to do
    world().barrier();
    EXPECT_EQ(streams_in(scratch), (std::set<int>{2, 3}));
    world().barrier();
    release_phases(build.workspace(), 2, 2);
    world().barrier();
    EXPECT_EQ(streams_in(scratch), (std::set<int>{3}));
  }
  const TestBuild build(folder, {}, true);
  EXPECT_EQ(run(build.workspace(), "first", kSalts).work_count(), 0U);
  EXPECT_EQ(run(build.workspace(), "second", kSalts).work_count(), 0U);
  const Outcome outcome = run(build.workspace(), "third", kSalts);
  EXPECT_EQ(outcome.work_count(), 0U);
  expect_results(build.workspace(), outcome, kSalts);
  run(build.workspace(), "fourth", kSalts);
  release_phases_up_to(build.workspace(), 3);  // files of an earlier attempt
  world().barrier();
  EXPECT_EQ(streams_in(build.workspace().scratch.folder), (std::set<int>{4}));
}

// What was released is needed again to make what is damaged.
TEST(Phase, ThatWasReleasedIsDoneAgainWhereALaterOneIsDamaged) {
  const CommonFolder folder;
  std::vector<scratch::RecordRef> records;
  std::filesystem::path scratch;
  {
    const TestBuild build(folder);
    run(build.workspace(), "first", kSalts);
    records = run(build.workspace(), "second", kSalts).records;
    run(build.workspace(), "third", kSalts);
    release_phases_up_to(build.workspace(), 1);
    scratch = build.workspace().scratch.folder;
  }
  if (world().is_root()) std::filesystem::resize_file(path_of(scratch, records[0].file), records[0].offset);
  world().barrier();
  const TestBuild build(folder, {}, true);
  EXPECT_EQ(run(build.workspace(), "first", kSalts).work_count(), kTasks);
  const Outcome outcome = run(build.workspace(), "second", kSalts);
  EXPECT_GT(outcome.work_count(), 0U);
  expect_results(build.workspace(), outcome, kSalts);
}

TEST(Phase, EndsWhereAnotherAttemptHasTakenOver) {
  const CommonFolder folder;
  const TestBuild build(folder);
  run(build.workspace(), "first", kSalts);
  EXPECT_FALSE(is_superseded(build.workspace()));
  world().barrier();
  if (world().is_root()) scratch::take_attempt(build.workspace().scratch.folder.parent_path(), 1);
  world().barrier();
  EXPECT_TRUE(is_superseded(build.workspace()));
  const Outcome outcome = run(build.workspace(), "second", kSalts);
  ASSERT_ALL(outcome.error.has_value());
  EXPECT_EQ(outcome.error->status(), core::Status::kIo);
  EXPECT_NE(std::string(outcome.error->what()).find("another attempt"), std::string::npos);
  EXPECT_EQ(outcome.work_count(), 0U);
  EXPECT_TRUE(error_of([&] { release_phases_up_to(build.workspace(), 1); }));
}

}  // namespace
}  // namespace colossus::pipeline::run
