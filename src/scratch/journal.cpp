#include "scratch/journal.hpp"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

namespace colossus::scratch {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;

enum RecordKind : std::uint16_t { kStart = 1, kTask = 2, kRelease = 3, kRecall = 4 };

// How a task's record begins; the extents follow, then the result.
struct TaskHeader {
  TaskKey key;
  std::uint64_t extent_count = 0;
};

FileId journal_of(std::uint16_t attempt, std::uint16_t rank) { return {attempt, rank, kJournalStream}; }

AttemptStart parse_start(std::span<const std::byte> payload) {
  ByteReader reader(payload);
  AttemptStart start;
  start.nonce = reader.get<std::uint64_t>();
  start.read = reader.get_array<JournalEnd>(reader.remaining() / sizeof(JournalEnd));
  return start;
}

bool is_before(const FinishedTask& a, const FinishedTask& b) {
  return std::tie(a.key.phase, a.key.index) < std::tie(b.key.phase, b.key.index);
}

std::uint64_t limit_in(std::span<const JournalEnd> limits, const FileId& file) {
  const auto found =
      std::find_if(limits.begin(), limits.end(), [&](const JournalEnd& end) { return end.file == file; });
  return found == limits.end() ? 0 : found->bytes;
}

}  // namespace

JournalWriter::JournalWriter(Location location, std::uint16_t attempt, std::uint16_t rank)
    : location_(std::move(location)), id_(journal_of(attempt, rank)) {}

RecordFile& JournalWriter::file() {
  if (!file_) file_.emplace(location_, id_);
  return *file_;
}

void JournalWriter::append_start(const AttemptStart& start) {
  const std::span<const std::uint64_t> nonce(&start.nonce, 1);
  file().append(kStart, {std::as_bytes(nonce), core::as_bytes(start.read)});
  file().flush();
}

void JournalWriter::append_task(const TaskKey& key, std::span<const Extent> extents,
                                std::span<const std::byte> result) {
  const TaskHeader header{key, extents.size()};
  file().append(kTask, {std::as_bytes(std::span(&header, 1)), core::as_bytes(extents), result});
}

void JournalWriter::append_release(std::span<const std::uint64_t> task_counts,
                                   std::span<const std::uint32_t> phases) {
  const std::uint64_t phase_count = task_counts.size();
  const std::span<const std::uint64_t> count(&phase_count, 1);
  file().append(kRelease, {core::as_bytes(count), core::as_bytes(task_counts), core::as_bytes(phases)});
  file().flush();
}

void JournalWriter::append_recall(std::span<const std::uint32_t> phases) {
  file().append(kRecall, {core::as_bytes(phases)});
  file().flush();
}

std::optional<AttemptStart> read_start(const Location& location, std::uint16_t attempt) {
  std::optional<AttemptStart> start;
  scan_records(location, journal_of(attempt, 0), std::numeric_limits<std::uint64_t>::max(),
               [&](const RecordRef& ref, std::span<const std::byte> payload) {
                 if (ref.kind == kStart && !start) start = parse_start(payload);
               });
  return start;
}

Bytes result_of_record(Bytes payload) {
  const auto header = ByteReader(payload).get<TaskHeader>();
  const std::size_t begin = sizeof header + header.extent_count * sizeof(Extent);
  COLOSSUS_CHECK(begin <= payload.size(), "{} of {} bytes", begin, payload.size());
  payload.erase(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(begin));
  return payload;
}

History History::read(const Location& location, std::span<const FileId> files,
                      const std::function<void()>& poll) {
  std::vector<FileId> journals;
  std::copy_if(files.begin(), files.end(), std::back_inserter(journals),
               [](const FileId& file) { return file.stream == kJournalStream; });
  std::sort(journals.begin(), journals.end());
  // The latest attempt that got as far as to read the journals of those before says how far they count; an
  // attempt that did not has done nothing else.
  History history;
  std::vector<JournalEnd> limits;
  for (auto journal = journals.rbegin(); journal != journals.rend(); ++journal) {
    if (journal->rank != 0) continue;
    const std::optional<AttemptStart> start = read_start(location, journal->attempt);
    if (!start) continue;
    limits = start->read;
    for (const FileId& other : journals)
      if (other.attempt == journal->attempt)
        limits.push_back({other, 0, std::numeric_limits<std::uint64_t>::max()});
    break;
  }
  history.read_journals(location, journals, limits, poll);
  return history;
}

void History::read_journals(const Location& location, std::span<const FileId> journals,
                            std::span<const JournalEnd> limits, const std::function<void()>& poll) {
  for (const FileId& journal : journals) {
    const std::uint64_t end = scan_records(location, journal, limit_in(limits, journal),
                                           [&](const RecordRef& ref, std::span<const std::byte> payload) {
                                             poll();
                                             take(ref, payload);
                                           });
    ends_.push_back({journal, 0, end});
  }
  // Of equals the last comes from the latest attempt, since journals are in order.
  std::stable_sort(tasks_.begin(), tasks_.end(), is_before);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tasks_.size(); ++i)
    if (i + 1 == tasks_.size() || is_before(tasks_[i], tasks_[i + 1])) {
      if (kept != i) tasks_[kept] = std::move(tasks_[i]);
      ++kept;
    }
  tasks_.resize(kept);
}

void History::take(const RecordRef& ref, std::span<const std::byte> payload) {
  ByteReader reader(payload);
  if (ref.kind == kTask) {
    const auto header = reader.get<TaskHeader>();
    FinishedTask task{header.key, reader.get_array<Extent>(header.extent_count), ref};
    if (reader.failed()) return;
    // Journals come attempt by attempt: what a later one has made again is no longer released.
    const auto released = released_.find(task.key.phase);
    if (released != released_.end() && released->second.attempt < ref.file.attempt) released_.erase(released);
    tasks_.push_back(std::move(task));
  } else if (ref.kind == kRelease) {
    std::vector<std::uint64_t> counts = reader.get_array<std::uint64_t>(reader.get<std::uint64_t>());
    const Release release{static_cast<std::uint32_t>(counts.size()), ref.file.attempt};
    for (const auto phase : reader.get_array<std::uint32_t>(reader.remaining() / sizeof(std::uint32_t)))
      released_[phase] = release;
    if (counts.size() > task_counts_.size()) task_counts_ = std::move(counts);
  } else if (ref.kind == kRecall) {
    for (const auto phase : reader.get_array<std::uint32_t>(reader.remaining() / sizeof(std::uint32_t)))
      released_.erase(phase);
  }
}

bool History::is_needed(const FinishedTask& task, const Extent& extent) const {
  return extent.file.stream == kKeptStream || !released_.contains(task.key.phase);
}

std::vector<Extent> History::needed_extents() const {
  std::vector<Extent> extents;
  for (const FinishedTask& task : tasks_)
    for (const Extent& extent : task.extents)
      if (is_needed(task, extent)) extents.push_back(extent);
  return extents;
}

// Or the largest number.
std::uint32_t History::first_phase_with_lost_records() const {
  for (std::uint32_t phase = 1; phase <= task_counts_.size(); ++phase) {
    const auto is_of_phase = [&](const FinishedTask& task) { return task.key.phase == phase; };
    const auto count = std::count_if(tasks_.begin(), tasks_.end(), is_of_phase);
    if (static_cast<std::uint64_t>(count) < task_counts_[phase - 1]) return phase;
  }
  return std::numeric_limits<std::uint32_t>::max();
}

std::vector<std::uint32_t> History::forget_damaged(const std::vector<bool>& is_damaged) {
  std::uint32_t first_phase = first_phase_with_lost_records();
  std::size_t next = 0;
  std::erase_if(tasks_, [&](const FinishedTask& task) {
    bool is_bad = false;
    for (const Extent& extent : task.extents)
      if (is_needed(task, extent)) is_bad |= is_damaged.at(next++);
    if (is_bad) first_phase = std::min(first_phase, task.key.phase);
    return is_bad;
  });
  // What is done again needs its input, and whatever is made from it may need more: all that was released
  // when the phase was complete is missing, and to make that takes what was released before, and so on.
  std::vector<std::uint32_t> recalled;
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (auto it = released_.begin(); it != released_.end();) {
      const std::uint32_t phase = it->first;
      if (it->second.phase_count < first_phase) {
        ++it;
        continue;
      }
      recalled.push_back(phase);
      first_phase = std::min(first_phase, phase);
      it = released_.erase(it);
      is_changed = true;
    }
  }
  std::sort(recalled.begin(), recalled.end());
  std::erase_if(tasks_, [&](const FinishedTask& task) {
    return std::binary_search(recalled.begin(), recalled.end(), task.key.phase) &&
           std::any_of(task.extents.begin(), task.extents.end(),
                       [](const Extent& extent) { return extent.file.stream != kKeptStream; });
  });
  return recalled;
}

std::vector<std::uint32_t> History::released_phases() const {
  std::vector<std::uint32_t> phases;
  for (const auto& [phase, release] : released_) phases.push_back(phase);
  return phases;
}

std::vector<FinishedTask> History::take_phase(std::uint32_t phase, std::uint64_t phase_hash) {
  FinishedTask probe;
  probe.key.phase = phase;
  const auto begin = std::lower_bound(tasks_.begin(), tasks_.end(), probe, is_before);
  probe.key.phase = phase + 1;
  const auto end = std::lower_bound(begin, tasks_.end(), probe, is_before);
  std::vector<FinishedTask> taken(std::make_move_iterator(begin), std::make_move_iterator(end));
  tasks_.erase(tasks_.begin(), end);  // phases come in order
  std::erase_if(taken, [&](const FinishedTask& task) { return task.key.phase_hash != phase_hash; });
  return taken;
}

}  // namespace colossus::scratch
