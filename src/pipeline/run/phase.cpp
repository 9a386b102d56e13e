#include "pipeline/run/phase.hpp"

#include <algorithm>

#include "cluster/stop.hpp"
#include "core/hash.hpp"
#include "core/log.hpp"
#include "pipeline/run/progress.hpp"
#include "scratch/directory.hpp"

namespace colossus::pipeline::run {
namespace {

using core::Bytes;
using scratch::FileId;
using scratch::FinishedTask;
using scratch::TaskKey;

std::uint64_t hash_of_name(const std::string& name) {
  return core::hash64(std::as_bytes(std::span(name.data(), name.size())));
}

// Hands out the results of earlier attempts, and returns the tasks that are left. On rank 0.
std::vector<std::size_t> replay(const Workspace& workspace, const std::string& name, std::size_t task_count,
                                const cluster::MakeTask& make_task, const cluster::TakeResult& on_result) {
  const std::uint32_t phase = workspace.progress.phase_count;
  const std::vector<FinishedTask> finished = workspace.progress.history.take_phase(phase, hash_of_name(name));
  std::vector<std::size_t> rest;
  auto next = finished.begin();
  for (std::size_t task = 0; task < task_count; ++task) {
    while (next != finished.end() && next->key.index < task) ++next;
    const bool is_known = next != finished.end() && next->key.index == task;
    if (is_known && next->key.task_hash == core::hash64(make_task(task))) {
      cluster::throw_if_stop_requested();
      on_result(task, scratch::result_of_record(workspace.reader.read(next->record)));
    } else {
      rest.push_back(task);
    }
  }
  if (rest.size() < task_count)
    core::log("resume: {}: {} of {} tasks are done", name, task_count - rest.size(), task_count);
  return rest;
}

// A task's number, then what make_task made.
Bytes with_number(std::size_t task, std::span<const std::byte> made) {
  core::ByteWriter writer;
  writer.put<std::uint64_t>(task);
  writer.put_bytes(made);
  return writer.take();
}

Bytes work_and_record(const Workspace& workspace, std::uint64_t name_hash,
                      std::span<const std::byte> numbered, const cluster::Work& work) {
  core::ByteReader reader(numbered);
  const auto number = reader.get<std::uint64_t>();
  const auto task = reader.get_bytes(reader.remaining());
  const scratch::SpoolWriter::Ends before = workspace.writer.ends();
  Bytes result = work(task);
  workspace.writer.flush();
  const TaskKey key{workspace.progress.phase_count, 0, name_hash, number, core::hash64(task)};
  workspace.progress.journal.append_task(key, workspace.writer.extents_since(before), result);
  return result;
}

bool is_in(const FileId& file, std::uint32_t first, std::uint32_t last) {
  return file.stream >= first && file.stream <= last && file.stream != scratch::kJournalStream;
}

}  // namespace

void run_phase(const Workspace& workspace, const std::string& name, std::size_t task_count,
               const cluster::MakeTask& make_task, const cluster::Work& work,
               const cluster::TakeResult& on_result) {
  const std::uint32_t phase = ++workspace.progress.phase_count;
  COLOSSUS_CHECK(phase < scratch::kJournalStream, "{} phases", phase);
  workspace.progress.task_counts.push_back(task_count);
  workspace.writer.begin_stream(static_cast<std::uint16_t>(phase));
  std::vector<std::size_t> rest;
  workspace.ranks.attempt([&] {
    if (!workspace.ranks.is_root()) return;
    check_not_superseded(workspace);
    rest = replay(workspace, name, task_count, make_task, on_result);
  });
  const std::uint64_t name_hash = hash_of_name(name);
  workspace.reporter.begin_phase(name, task_count, task_count - rest.size());
  const scratch::SpoolWriter::Ends before = workspace.writer.ends();
  const cluster::FarmShare share = cluster::run_farm(
      workspace.ranks, rest.size(), [&](std::size_t i) { return with_number(rest[i], make_task(rest[i])); },
      [&](std::span<const std::byte> task) { return work_and_record(workspace, name_hash, task, work); },
      [&](std::size_t i, Bytes result) {
        on_result(rest[i], std::move(result));
        workspace.reporter.finish_task();
      });
  PhaseShare mine;
  mine.tasks = share.task_count;
  mine.work_seconds = share.work_seconds;
  for (const scratch::Extent& extent : workspace.writer.extents_since(before))
    mine.scratch_bytes += extent.end - extent.begin;
  workspace.reporter.end_phase(mine);
  if (workspace.ranks.is_root()) workspace.reporter.note_scratch(scratch::bytes_in(workspace.scratch.folder));
}

std::uint32_t last_phase(const Workspace& workspace) { return workspace.progress.phase_count; }

void release_phases(const Workspace& workspace, std::uint32_t first, std::uint32_t last) {
  Progress& progress = workspace.progress;
  if (first > last) return;
  COLOSSUS_CHECK(first > 0 && last < progress.phase_count, "{} to {} of {}", first, last,
                 progress.phase_count);
  const bool is_root = workspace.ranks.is_root();
  // Who resumes must know that the data is not missed, before it is missing.
  workspace.ranks.attempt([&] {
    if (!is_root) return;
    check_not_superseded(workspace);
    std::vector<std::uint32_t> phases;
    for (std::uint32_t phase = first; phase <= last; ++phase) phases.push_back(phase);
    progress.journal.append_release(progress.task_counts, phases);
  });
  workspace.reader.forget(static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(last));
  workspace.ranks.attempt([&] {
    std::vector<FileId> files;
    for (std::uint32_t phase = first; phase <= last; ++phase)
      files.push_back({progress.journal.attempt(), static_cast<std::uint16_t>(workspace.ranks.rank()),
                       static_cast<std::uint16_t>(phase)});
    std::copy_if(progress.earlier_files.begin(), progress.earlier_files.end(), std::back_inserter(files),
                 [&](const FileId& file) { return is_in(file, first, last); });
    std::erase_if(progress.earlier_files, [&](const FileId& file) { return is_in(file, first, last); });
    scratch::remove_files(workspace.scratch.folder, files);
  });
}

void release_phases_up_to(const Workspace& workspace, std::uint32_t last) {
  release_phases(workspace, workspace.progress.released_up_to + 1, last);
  workspace.progress.released_up_to = last;
}

bool is_superseded(const Workspace& workspace) {
  std::error_code ignored;
  return !std::filesystem::exists(workspace.scratch.folder, ignored) && !ignored;
}

void check_not_superseded(const Workspace& workspace) {
  if (is_superseded(workspace)) throw superseded_error(workspace);
}

core::Error superseded_error(const Workspace& workspace) {
  return {
      core::Status::kIo,
      fmt::format("{}: this attempt at the build ends: its scratch directory was removed, or another attempt "
                  "has begun and takes over",
                  workspace.scratch.folder.string())};
}

}  // namespace colossus::pipeline::run
