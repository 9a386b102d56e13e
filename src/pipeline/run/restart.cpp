#include "pipeline/run/restart.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <random>
#include <thread>

#include "cluster/farm.hpp"
#include "cluster/stop.hpp"
#include "core/log.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::run {
namespace {

using core::Bytes;
using core::Status;
using scratch::Extent;
using scratch::FileId;
using scratch::Location;

// A task of checking extents takes about a tenth of a second of a disk.
constexpr std::uint64_t kMostCheckedBytes = std::uint64_t{64} << 20;
constexpr std::size_t kMostCheckedExtents = 1024;

// How often a rank looks for rank 0's file: a network file system may take a moment to show it.
constexpr int kLooks = 20;
constexpr std::chrono::milliseconds kBetweenLooks{100};

// What rank 0 tells the others.
struct Announcement {
  std::uint64_t key = 0;
  std::uint64_t nonce = 0;
  std::uint16_t attempt = 0;
  bool is_resumed = false;
};

std::uint64_t random_number() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

class Opening {
 public:
  Opening(const cluster::Communicator& ranks, const std::filesystem::path& directory, bool may_resume,
          const scratch::Manifest& manifest, bool is_own_name)
      : ranks_(ranks),
        directory_(directory),
        may_resume_(may_resume),
        manifest_(manifest),
        is_own_name_(is_own_name) {}

  OpenedScratch run() {
    try {
      ranks_.attempt([&] {
        if (ranks_.is_root()) begin_attempt();
      });
      broadcast_value(ranks_, announcement_);
      location_ = {scratch::folder_of_attempt(directory_, announcement_.attempt), announcement_.key};
      prove_shared();
      if (announcement_.is_resumed) check_history();
    } catch (const core::Error&) {
      if (is_created_) remove_quietly();
      throw;
    }
    if (!journal_) journal_.emplace(location_, announcement_.attempt, own_rank());
    return {location_,
            {std::move(*journal_), announcement_.is_resumed, 0, 0, {}, std::move(history_), files_}};
  }

 private:
  std::uint16_t own_rank() const { return static_cast<std::uint16_t>(ranks_.rank()); }

  void begin_attempt() {
    if (ranks_.size() > scratch::kJournalStream)
      core::fail(Status::kUsage, "{} ranks are too many; start at most {}", ranks_.size(),
                 scratch::kJournalStream);
    const std::uint16_t attempt = prepare_directory();
    location_ = {scratch::folder_of_attempt(directory_, attempt), manifest_.key()};
    files_ = scratch::look_into(location_.folder).files;
    history_ = scratch::History::read(location_, files_, &cluster::throw_if_stop_requested);
    announcement_ = {manifest_.key(), random_number(), attempt, !files_.empty()};
    journal_.emplace(location_, attempt, std::uint16_t{0});
    journal_->append_start({announcement_.nonce, history_.journal_ends()});
  }

  // Returns the number of this attempt, which now has the directory.
  std::uint16_t prepare_directory() {
    for (int look = 0;; ++look) {
      const scratch::DirectoryContent content = scratch::look_into_directory(directory_);
      try {
        return take_directory(content);
      } catch (const core::Error&) {
        // Ranks of an earlier attempt that still lived may have come to the end, and removed what was found.
        if (look == kLooks || content.attempt == 0 || scratch::look_into_directory(directory_).attempt != 0)
          throw;
      }
    }
  }

  std::uint16_t take_directory(scratch::DirectoryContent content) {
    if (!content.exists || content.is_empty) {
      if (may_resume_) core::log("resume: there is no scratch in {}: starting anew", directory_.string());
      is_created_ = begin_in(content);
      content = scratch::look_into_directory(directory_);
      if (is_created_) {
        scratch::write_manifest(scratch::folder_of_attempt(directory_, content.attempt), manifest_);
        return content.attempt;
      }
    }
    if (content.has_foreign && content.attempt == 0)
      core::fail(Status::kCannotCreate,
                 "{}: this folder is not empty, and is no scratch directory: choose another or an empty one "
                 "with --scratch",
                 directory_.string());
    if (!may_resume_)
      core::fail(Status::kCannotCreate,
                 "{}: the scratch directory exists already: another build is using it, or was interrupted; "
                 "continue it with --resume, or remove it if no build is running",
                 directory_.string());
    if (content.has_foreign) fail_foreign("this is no scratch directory");
    return continue_after(content.attempt);
  }

  // False when somebody else was faster.
  bool begin_in(const scratch::DirectoryContent& content) const {
    if (!content.exists) return scratch::create_scratch_directory(directory_);
    if (!may_resume_ || !is_own_name_) return scratch::use_empty_directory(directory_);
    scratch::take_attempt(directory_, 0);
    return true;
  }

  std::uint16_t continue_after(std::uint16_t latest) const {
    bool is_begun = false;
    if (latest > 0) {
      const std::filesystem::path folder = scratch::folder_of_attempt(directory_, latest);
      const scratch::FolderContent content = scratch::look_into(folder);
      const std::optional<scratch::Manifest> there = scratch::read_manifest(folder);
      if (there) check_same(*there);
      // A build may be killed before its manifest is complete; nothing else is there then.
      if (!there && !content.files.empty()) fail_foreign("the manifest is damaged");
      if (content.has_foreign) fail_foreign("there are files that are no scratch files");
      is_begun = there.has_value();
    }
    const std::uint16_t attempt = scratch::take_attempt(directory_, latest);
    if (!is_begun) {
      const std::filesystem::path folder = scratch::folder_of_attempt(directory_, attempt);
      scratch::remove_manifest(folder);
      scratch::write_manifest(folder, manifest_);
    }
    return attempt;
  }

  [[noreturn]] void fail_foreign(const char* what) const {
    core::fail(Status::kCannotCreate,
               "{}: cannot resume: {}: remove it, or choose another directory with --scratch",
               directory_.string(), what);
  }

  void check_same(const scratch::Manifest& there) const {
    const std::string difference = manifest_.difference_from(there);
    if (difference.empty()) return;
    core::fail(Status::kUsage,
               "{}: cannot resume: the scratch directory is that of another build: {}: repeat the command of "
               "that build, or remove the directory to start anew",
               directory_.string(), difference);
  }

  // Every rank finds the number that rank 0 has written into its journal.
  void prove_shared() {
    const std::vector<std::string> hosts = ranks_.host_names();
    ranks_.attempt([&] {
      for (int look = 0; !ranks_.is_root(); ++look) {
        const auto start = scratch::read_start(location_, announcement_.attempt);
        if (start && start->nonce == announcement_.nonce) return;
        if (look == kLooks)
          core::fail(
              Status::kIo,
              "{}: rank {} on {} does not see the scratch directory that rank 0 on {} uses: choose one on "
              "a file system that all hosts share with --scratch",
              directory_.string(), ranks_.rank(), hosts[static_cast<std::size_t>(ranks_.rank())], hosts[0]);
        std::this_thread::sleep_for(kBetweenLooks);
      }
    });
  }

  // All ranks look whether what the finished tasks have made is intact.
  void check_history() {
    const std::vector<Extent> extents = history_.needed_extents();
    const std::vector<std::size_t> firsts = first_extents_of_tasks(extents);
    std::vector<bool> is_damaged(extents.size(), false);
    const std::size_t task_count = firsts.empty() ? 0 : firsts.size() - 1;
    cluster::run_farm(
        ranks_, task_count,
        [&](std::size_t task) {
          const auto view =
              core::as_bytes(std::span(extents).subspan(firsts[task], firsts[task + 1] - firsts[task]));
          return Bytes(view.begin(), view.end());
        },
        [&](std::span<const std::byte> task) { return check_extents(task); },
        [&](std::size_t task, const Bytes& verdicts) {
          for (std::size_t i = 0; i < verdicts.size(); ++i)
            is_damaged[firsts[task] + i] = verdicts[i] != std::byte{0};
        });
    ranks_.attempt([&] {
      if (ranks_.is_root()) settle(extents, is_damaged);
    });
  }

  static std::vector<std::size_t> first_extents_of_tasks(const std::vector<Extent>& extents) {
    std::vector<std::size_t> firsts;
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < extents.size(); ++i) {
      if (firsts.empty() || bytes >= kMostCheckedBytes || i - firsts.back() >= kMostCheckedExtents) {
        firsts.push_back(i);
        bytes = 0;
      }
      bytes += extents[i].end - extents[i].begin;
    }
    if (!firsts.empty()) firsts.push_back(extents.size());
    return firsts;
  }

  Bytes check_extents(std::span<const std::byte> task) const {
    Bytes verdicts;
    for (const Extent& extent : core::ByteReader(task).get_array<Extent>(task.size() / sizeof(Extent)))
      verdicts.push_back(is_intact(location_, extent, &cluster::throw_if_stop_requested) ? std::byte{0}
                                                                                         : std::byte{1});
    return verdicts;
  }

  void settle(const std::vector<Extent>& extents, const std::vector<bool>& is_damaged) {
    std::uint64_t bytes = 0;
    for (const Extent& extent : extents) bytes += extent.end - extent.begin;
    const std::size_t found_count = history_.task_count();
    const std::vector<std::uint32_t> recalled = history_.forget_damaged(is_damaged);
    core::log("resume: attempt {}: {} finished tasks, {} MB of scratch checked, {} tasks to be done again",
              announcement_.attempt, found_count, bytes >> 20, found_count - history_.task_count());
    if (!recalled.empty()) journal_->append_recall(recalled);
    // An attempt may be killed between the note that data is superfluous and its deletion.
    std::vector<std::uint32_t> superfluous = history_.released_phases();
    superfluous.insert(superfluous.end(), recalled.begin(), recalled.end());
    std::vector<FileId> files;
    std::copy_if(files_.begin(), files_.end(), std::back_inserter(files), [&](const FileId& file) {
      return std::find(superfluous.begin(), superfluous.end(), file.stream) != superfluous.end();
    });
    scratch::remove_files(location_.folder, files);
  }

  void remove_quietly() {
    journal_.reset();
    try {
      scratch::remove_scratch_directory(directory_, scratch::look_into_directory(directory_).attempt);
    } catch (const core::Error& error) {
      core::warn_line(error.what());
    }
  }

  const cluster::Communicator& ranks_;
  const std::filesystem::path& directory_;
  bool may_resume_;
  const scratch::Manifest& manifest_;
  bool is_own_name_;
  Location location_;
  Announcement announcement_;
  std::optional<scratch::JournalWriter> journal_;
  // On rank 0:
  bool is_created_ = false;
  scratch::History history_;
  std::vector<FileId> files_;  // of earlier attempts
};

}  // namespace

OpenedScratch open_scratch(const cluster::Communicator& ranks, const std::filesystem::path& directory,
                           bool may_resume, const scratch::Manifest& manifest, bool is_own_name) {
  return Opening(ranks, directory, may_resume, manifest, is_own_name).run();
}

}  // namespace colossus::pipeline::run
