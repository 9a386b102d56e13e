// Journals: what the ranks of a build have finished, so that a later attempt need not do it again.
//
// Each rank of each attempt has a journal of its own; rank 0's also says which attempt it is and which data
// has been deleted. A process that is killed at any moment leaves whole records and at most one torn one.
// Nothing is forced to the disk: what a crash of the machine loses is found missing, and done again.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/bytes.hpp"
#include "scratch/record.hpp"

namespace colossus::scratch {

// Which task of a build.
struct TaskKey {
  std::uint32_t phase = 0;  // phases are numbered from 1, in the order in which they run
  std::uint32_t padding = 0;
  std::uint64_t phase_hash = 0;  // of the phase's name
  std::uint64_t index = 0;       // in the phase
  std::uint64_t task_hash = 0;   // of what the task was made from
  friend bool operator==(const TaskKey&, const TaskKey&) = default;
};

// How far the journal of one rank of an earlier attempt was read.
struct JournalEnd {
  FileId file;
  std::uint16_t padding = 0;
  std::uint64_t bytes = 0;
};

// The first record of rank 0's journal. What an earlier attempt appends after `read` was taken is void: its
// ranks may still live though it was killed.
struct AttemptStart {
  std::uint64_t nonce = 0;  // by which other ranks know the file
  std::vector<JournalEnd> read;
};

// Appends to the journal of one rank. Throws like RecordFile.
class JournalWriter {
 public:
  // The file is created by the first append.
  JournalWriter(Location location, std::uint16_t attempt, std::uint16_t rank);
  std::uint16_t attempt() const { return id_.attempt; }

  void append_start(const AttemptStart& start);
  // `extents`: where in scratch the task's output lies.
  void append_task(const TaskKey& key, std::span<const Extent> extents, std::span<const std::byte> result);
  // The streams of `phases` are no longer needed by any phase after the first ones, which are complete and
  // had `task_counts` tasks each. To be appended before they are deleted.
  void append_release(std::span<const std::uint64_t> task_counts, std::span<const std::uint32_t> phases);
  // The opposite: they are needed, and must be made again.
  void append_recall(std::span<const std::uint32_t> phases);

 private:
  RecordFile& file();

  Location location_;
  FileId id_;
  std::optional<RecordFile> file_;
};

// The start of an attempt, should its journal have one.
std::optional<AttemptStart> read_start(const Location& location, std::uint16_t attempt);

// A task that was finished by an earlier attempt.
struct FinishedTask {
  TaskKey key;
  std::vector<Extent> extents;
  RecordRef record;  // in the journal
};

// The result, out of the payload of a task's record.
core::Bytes result_of_record(core::Bytes payload);

// What earlier attempts have left: which tasks are finished, and which data was deleted since. On one rank.
// Memory: some hundred bytes per task.
class History {
 public:
  History() = default;
  // Reads the journals among `files`, all of which are of earlier attempts. Of a task that was done twice,
  // the later attempt's counts. Records that are not intact are as if they were not there. `poll` is called
  // for each record, and may throw.
  static History read(const Location& location, std::span<const FileId> files,
                      const std::function<void()>& poll);

  // How far each journal was read.
  const std::vector<JournalEnd>& journal_ends() const { return ends_; }
  std::size_t task_count() const { return tasks_.size(); }

  // All extents that must be intact for the tasks to count, in a fixed order: those of released phases need
  // not, but in the kept stream.
  std::vector<Extent> needed_extents() const;
  // Forgets the tasks that have a damaged extent; `is_damaged` is parallel to needed_extents(). They have to
  // be done again, as have tasks of complete phases whose records are lost, and so have phases that were
  // released since: these are forgotten, too, and returned.
  std::vector<std::uint32_t> forget_damaged(const std::vector<bool>& is_damaged);

  // Phases whose streams are superfluous.
  std::vector<std::uint32_t> released_phases() const;

  // Moves the tasks of one phase out, by index. Those of a phase of another name are dropped.
  std::vector<FinishedTask> take_phase(std::uint32_t phase, std::uint64_t phase_hash);

 private:
  void read_journals(const Location& location, std::span<const FileId> journals,
                     std::span<const JournalEnd> limits, const std::function<void()>& poll);
  void take(const RecordRef& ref, std::span<const std::byte> payload);
  bool is_needed(const FinishedTask& task, const Extent& extent) const;
  std::uint32_t first_phase_with_lost_records() const;

  struct Release {
    std::uint32_t phase_count = 0;  // how many phases were complete then
    std::uint16_t attempt = 0;      // by which it was noted
  };
  std::vector<FinishedTask> tasks_;            // by phase and index
  std::map<std::uint32_t, Release> released_;  // by phase
  std::vector<std::uint64_t> task_counts_;  // of phases that are known to have been complete, from the first
  std::vector<JournalEnd> ends_;
};

}  // namespace colossus::scratch
