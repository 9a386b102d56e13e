#include "scratch/journal.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <set>

#include "scratch/directory.hpp"
#include "scratch/spool.hpp"
#include "support/temporary_directory.hpp"

namespace colossus::scratch {

using namespace support;
namespace {

using core::Bytes;

constexpr std::uint64_t kKey = 77;
constexpr std::uint64_t kNameHash = 5;

TaskKey key_of(std::uint32_t phase, std::uint64_t index) {
  return {phase, 0, kNameHash + phase, index, 1000 * phase + index};
}

// What one rank of one attempt does.
class Rank {
 public:
  Rank(const Location& location, std::uint16_t attempt, std::uint16_t rank)
      : journal(location, attempt, rank), spool_(location, attempt, rank) {}

  // Appends a mesh to the phase's stream and, should it have one, a chunk, then the task's record.
  std::vector<Extent> finish(std::uint32_t phase, std::uint64_t index, bool has_chunk = false) {
    if (phase != phase_) spool_.begin_stream(static_cast<std::uint16_t>(phase_ = phase));
    const SpoolWriter::Ends before = spool_.ends();
    spool_.append(1, Bytes(10 * phase + index, std::byte{1}));
    if (has_chunk) spool_.append_kept(2, Bytes(20, std::byte{2}));
    const std::vector<Extent> extents = spool_.extents_since(before);
    journal.append_task(key_of(phase, index), extents, result_of(phase, index));
    return extents;
  }
  static Bytes result_of(std::uint32_t phase, std::uint64_t index) {
    return Bytes(3 * phase + index, static_cast<std::byte>(index));
  }

  JournalWriter journal;

 private:
  SpoolWriter spool_;
  std::uint32_t phase_ = 0;
};

class Journals : public ::testing::Test {
 protected:
  History history() const {
    return History::read(location_, look_into(directory_.path()).files, [] {});
  }
  // By phase and index, as "phase.index@attempt", separated by blanks.
  static std::string tasks_of(History history) {
    std::string text;
    for (std::uint32_t phase = 1; phase < 20; ++phase)
      for (const FinishedTask& task : history.take_phase(phase, kNameHash + phase))
        text += fmt::format("{}{}.{}@{}", text.empty() ? "" : " ", task.key.phase, task.key.index,
                            task.record.file.attempt);
    return text;
  }
  std::filesystem::path journal_path(std::uint16_t attempt, std::uint16_t rank) const {
    return path_of(directory_.path(), {attempt, rank, kJournalStream});
  }
  std::uint16_t next_number() const {
    std::uint16_t number = 1;
    for (const FileId& file : look_into(directory_.path()).files)
      number = std::max(number, static_cast<std::uint16_t>(file.attempt + 1));
    return number;
  }
  // As at the start of an attempt: reads what is there, checks it, and notes both. Says what was recalled.
  Rank next_attempt(std::vector<std::uint32_t>* recalled = nullptr) const {
    const std::vector<FileId> files = look_into(directory_.path()).files;
    JournalWriter journal(location_, next_number(), 0);
    History found = History::read(location_, files, [] {});
    journal.append_start({17, found.journal_ends()});
    std::vector<bool> is_damaged;
    for (const Extent& extent : found.needed_extents())
      is_damaged.push_back(!is_intact(location_, extent, [] {}));
    const std::vector<std::uint32_t> phases = found.forget_damaged(is_damaged);
    if (!phases.empty()) journal.append_recall(phases);
    if (recalled) *recalled = phases;
    Rank rank(location_, journal.attempt(), 0);
    rank.journal = std::move(journal);
    return rank;
  }
  void remove_stream(std::uint16_t attempt, std::uint16_t rank, std::uint16_t stream) const {
    remove_files(directory_.path(), {{attempt, rank, stream}});
  }

  TemporaryDirectory directory_;
  Location location_{directory_.path(), kKey};
};

TEST_F(Journals, TellWhatWasFinishedWhereItLiesAndWithWhichResult) {
  Rank first = next_attempt();
  Rank second(location_, 1, 1);
  const std::vector<Extent> extents = second.finish(2, 7, true);
  first.finish(1, 4);
  second.finish(2, 0);
  first.finish(1, 2);
  History found = history();
  EXPECT_EQ(found.task_count(), 4U);
  EXPECT_EQ(tasks_of(found), "1.2@1 1.4@1 2.0@1 2.7@1");
  EXPECT_EQ(found.take_phase(1, kNameHash + 1).size(), 2U);
  const std::vector<FinishedTask> tasks = found.take_phase(2, kNameHash + 2);
  ASSERT_EQ(tasks.size(), 2U);
  EXPECT_EQ(tasks[1].key, key_of(2, 7));
  EXPECT_EQ(tasks[1].extents, extents);
  EXPECT_EQ(result_of_record(SpoolReader(location_).read(tasks[1].record)), Rank::result_of(2, 7));
  EXPECT_EQ(found.task_count(), 0U);
  EXPECT_TRUE(history().take_phase(1, 99).empty()) << "a phase of another name";
}

TEST_F(Journals, AreReadUpToTheLastWholeRecordWhereverTheyAreCut) {
  std::vector<std::uint64_t> ends;
  {
    Rank rank = next_attempt();
    ends.push_back(std::filesystem::file_size(journal_path(1, 0)));
    for (std::uint64_t index = 0; index < 3; ++index) {
      rank.finish(1, index);
      ends.push_back(std::filesystem::file_size(journal_path(1, 0)));
    }
  }
  const Bytes bytes = core::read_file(journal_path(1, 0));
  ASSERT_EQ(ends.back(), bytes.size());
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    std::filesystem::resize_file(journal_path(1, 0), size);
    const auto whole = std::upper_bound(ends.begin(), ends.end(), size) - ends.begin() - 1;
    EXPECT_EQ(static_cast<std::ptrdiff_t>(history().task_count()), std::max<std::ptrdiff_t>(whole, 0))
        << size;
    core::File::create(journal_path(1, 0)).write_at(0, bytes);
  }
}

TEST_F(Journals, AFlippedBitCostsTheOneRecordThatHasIt) {
  std::vector<std::uint64_t> ends;
  {
    Rank rank = next_attempt();
    ends.push_back(std::filesystem::file_size(journal_path(1, 0)));
    for (std::uint64_t index = 0; index < 3; ++index) {
      rank.finish(1, index);
      ends.push_back(std::filesystem::file_size(journal_path(1, 0)));
    }
  }
  const Bytes bytes = core::read_file(journal_path(1, 0));
  for (std::size_t byte = 0; byte < bytes.size(); ++byte) {
    Bytes damaged = bytes;
    damaged[byte] ^= std::byte{0x10};
    core::File::create(journal_path(1, 0)).write_at(0, damaged);
    const auto record = std::upper_bound(ends.begin(), ends.end(), byte) - ends.begin();
    // Without the start of an attempt nothing of it is trusted: it may be one that was not to begin.
    const std::string expected = record == 0   ? ""
                                 : record == 1 ? "1.1@1 1.2@1"
                                 : record == 2 ? "1.0@1 1.2@1"
                                               : "1.0@1 1.1@1";
    EXPECT_EQ(tasks_of(history()), expected) << byte;
  }
}

TEST_F(Journals, OfAnotherBuildOrNameAreNotTrusted) {
  next_attempt().finish(1, 0);
  EXPECT_EQ(history().task_count(), 1U);
  EXPECT_EQ(
      History::read({directory_.path(), kKey + 1}, look_into(directory_.path()).files, [] {}).task_count(),
      0U);
  std::filesystem::rename(journal_path(1, 0), journal_path(2, 0));
  EXPECT_EQ(history().task_count(), 0U);
  std::ofstream(journal_path(3, 0)) << "something else altogether, longer than a header of a record is";
  EXPECT_EQ(history().task_count(), 0U);
}

TEST_F(Journals, OfATaskThatWasDoneTwiceTheLaterAttemptCounts) {
  next_attempt().finish(1, 0);
  Rank second = next_attempt();
  second.finish(1, 0);
  second.finish(1, 1);
  EXPECT_EQ(tasks_of(history()), "1.0@2 1.1@2");
}

TEST_F(Journals, WhatAStaleRankAppendsAfterTheNextAttemptBeganIsVoid) {
  Rank stale = next_attempt();
  Rank stale_worker(location_, 1, 1);
  stale.finish(1, 0);
  stale_worker.finish(1, 1);
  Rank second = next_attempt();
  EXPECT_EQ(second.journal.attempt(), 2);
  stale.finish(1, 2);
  stale_worker.finish(1, 3);
  stale.journal.append_release(std::vector<std::uint64_t>{1}, std::vector<std::uint32_t>{1});
  second.finish(1, 4);
  Rank(location_, 1, 2).finish(1, 5);
  EXPECT_EQ(tasks_of(history()), "1.0@1 1.1@1 1.4@2");
  EXPECT_TRUE(history().released_phases().empty());
  // The same seen by the attempt after an attempt that was killed at once.
  std::ofstream(journal_path(next_number(), 0));
  EXPECT_EQ(tasks_of(history()), "1.0@1 1.1@1 1.4@2");
  EXPECT_EQ(next_attempt().journal.attempt(), 4);
  EXPECT_EQ(tasks_of(history()), "1.0@1 1.1@1 1.4@2");
}

TEST_F(Journals, DamagedOutputCostsItsTask) {
  {
    Rank rank = next_attempt();
    rank.finish(1, 0);
    const Extent damaged = rank.finish(1, 1)[0];
    rank.finish(1, 2);
    std::fstream file(path_of(directory_.path(), damaged.file),
                      std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(damaged.begin + kRecordHeaderBytes));
    file.put('x');
  }
  History found = history();
  std::vector<bool> is_damaged;
  for (const Extent& extent : found.needed_extents())
    is_damaged.push_back(!is_intact(location_, extent, [] {}));
  EXPECT_EQ(is_damaged, (std::vector<bool>{false, true, false}));
  EXPECT_TRUE(found.forget_damaged(is_damaged).empty());
  EXPECT_EQ(tasks_of(found), "1.0@1 1.2@1");
}

// Three phases, each made from the one before; the first two have been released.
class Released : public Journals {
 protected:
  Released() {
    Rank rank = next_attempt();
    rank.finish(1, 0);
    rank.finish(2, 0, true);
    rank.journal.append_release(std::vector<std::uint64_t>{1, 1}, std::vector<std::uint32_t>{1});
    rank.finish(3, 0);
    rank.journal.append_release(std::vector<std::uint64_t>{1, 1, 1}, std::vector<std::uint32_t>{2});
    rank.finish(4, 0);
    remove_stream(1, 0, 1);
    remove_stream(1, 0, 2);
  }
};

TEST_F(Released, DataIsNotMissed) {
  std::vector<std::uint32_t> recalled;
  next_attempt(&recalled);
  EXPECT_TRUE(recalled.empty());
  EXPECT_EQ(tasks_of(history()), "1.0@1 2.0@1 3.0@1 4.0@1");
  EXPECT_EQ(history().released_phases(), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(history().needed_extents().size(), 3U) << "the chunk of phase 2, and phases 3 and 4";
}

TEST_F(Released, DataIsMadeAgainWhenWhatWasMadeFromItIsDamaged) {
  remove_stream(1, 0, 3);
  std::vector<std::uint32_t> recalled;
  Rank second = next_attempt(&recalled);
  EXPECT_EQ(recalled, (std::vector<std::uint32_t>{1, 2})) << "phase 3 needs 2, which needs 1";
  second.finish(1, 0);
  EXPECT_EQ(tasks_of(history()), "1.0@2 2.0@1 3.0@1 4.0@1");
  next_attempt(&recalled);
  EXPECT_TRUE(recalled.empty()) << "they were recalled before";
  second.finish(2, 0, true);
  EXPECT_TRUE(history().released_phases().empty());
}

TEST_F(Released, DataIsNotMadeAgainForAPhaseThatWasUnderWay) {
  remove_stream(1, 0, 4);
  std::vector<std::uint32_t> recalled;
  next_attempt(&recalled);
  EXPECT_TRUE(recalled.empty());
}

TEST_F(Released, DataIsMadeAgainWhenARecordOfWhatWasMadeFromItIsLost) {
  // Whatever part of the journal is lost: what counts as done is whole, or was made from what still is.
  const Bytes bytes = core::read_file(journal_path(1, 0));
  std::set<std::string> seen;
  for (std::size_t byte = 0; byte < bytes.size(); byte += 8) {
    Bytes damaged = bytes;
    damaged[byte] ^= std::byte{0x10};
    core::File::create(journal_path(1, 0)).write_at(0, damaged);
    History found = history();
    std::vector<bool> is_damaged;
    for (const Extent& extent : found.needed_extents())
      is_damaged.push_back(!is_intact(location_, extent, [] {}));
    found.forget_damaged(is_damaged);
    seen.insert(tasks_of(std::move(found)));
  }
  // Without the start of the attempt; 1.0 or 2.0 or a release, so that what was released looks
  // damaged; 3.0; 4.0.
  EXPECT_EQ(seen, (std::set<std::string>{"", "3.0@1 4.0@1", "4.0@1", "1.0@1 2.0@1 3.0@1"}));
}

TEST_F(Released, DataThatALaterAttemptHasMadeAgainIsNotReleasedThoughTheRecallIsLost) {
  remove_stream(1, 0, 3);
  {
    Rank second = next_attempt();
    second.finish(1, 0);
    second.finish(2, 0, true);
  }
  const Bytes bytes = core::read_file(journal_path(2, 0));
  std::uint64_t recall = 0;
  scan_records(location_, {2, 0, kJournalStream}, bytes.size(),
               [&](const RecordRef& ref, std::span<const std::byte>) {
                 recall = ref.kind == 4 ? ref.offset : recall;
               });
  ASSERT_GT(recall, 0U);
  Bytes damaged = bytes;
  damaged[recall] ^= std::byte{1};
  core::File::create(journal_path(2, 0)).write_at(0, damaged);
  EXPECT_TRUE(history().released_phases().empty());
}

TEST_F(Released, KeptDataIsStillNeeded) {
  remove_stream(1, 0, kKeptStream);
  std::vector<std::uint32_t> recalled;
  next_attempt(&recalled);
  EXPECT_EQ(recalled, (std::vector<std::uint32_t>{1, 2})) << "phase 2 is done again, from phase 1";
}

}  // namespace
}  // namespace colossus::scratch
