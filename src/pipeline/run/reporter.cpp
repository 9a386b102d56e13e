#include "pipeline/run/reporter.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <nlohmann/json.hpp>

#include "cluster/stop.hpp"
#include "core/bytes.hpp"
#include "core/escape.hpp"
#include "core/log.hpp"
#include "core/output_file.hpp"
#include "core/version.hpp"
#include "pipeline/facts/count_table.hpp"
#include "pipeline/facts/level_table.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/run/build_id.hpp"

namespace colossus::pipeline::run {
namespace {

using nlohmann::ordered_json;

#ifdef __clang__
constexpr const char* kCompiler = __VERSION__;  // begins with its name
#else
constexpr const char* kCompiler = "g++ " __VERSION__;
#endif

constexpr std::chrono::seconds kLineInterval{30};
constexpr std::chrono::seconds kStatusInterval{1};

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return stamp;
}

// Readers see the file as it was or as it is now, never half of it.
void replace_file(const core::OutputTarget& target, const std::string& text) {
  core::OutputFile file(target);
  file.append(std::as_bytes(std::span(text)));
  file.commit(core::OutputFile::Durability::kNone);
}

// Waits for a reader, but not when the build is asked to stop.
void write_to_stream(const core::OutputTarget& target, const std::string& text) {
  bool has_said = false;
  core::OutputFile file(target, [&] {
    if (cluster::is_stop_requested())
      core::fail(core::Status::kIo, "{}: nobody reads it, and the build was asked to stop",
                 target.path.string());
    if (!has_said) core::log("waiting for a reader of {}", target.path.string());
    has_said = true;
  });
  file.append(std::as_bytes(std::span(text)));
  file.commit(core::OutputFile::Durability::kNone);
}

std::string text_of(const ordered_json& json) { return core::with_escaped_texts(json).dump(2) + "\n"; }

// Over the ranks that work: rank 0 hands out tasks unless it is alone.
template <typename ValueOf>
ordered_json spread(const std::vector<PhaseShare>& shares, const ValueOf& value_of) {
  using Value = std::invoke_result_t<ValueOf, const PhaseShare&>;
  const std::span workers = std::span(shares).subspan(shares.size() > 1 ? 1 : 0);
  Value least = value_of(workers.front()), most = least, sum = 0;
  for (const PhaseShare& share : workers) {
    least = std::min(least, value_of(share));
    most = std::max(most, value_of(share));
    sum += value_of(share);
  }
  return {{"min", least},
          {"mean", static_cast<double>(sum) / static_cast<double>(workers.size())},
          {"max", most}};
}

ordered_json options_json(const facts::BuildOptions& options) {
  ordered_json json = ordered_json::object();
  facts::for_each_shaping_option([&](const facts::Option& option, auto member) {
    const auto* value = facts::given(std::invoke(member, options));
    if (option.help != nullptr && value != nullptr) json[option.name] = *value;
  });
  for (const auto& [name, value] : options.of_scheme)
    std::visit([&, &key = name](const auto& v) { json[key] = v; }, value);
  return json;
}

ordered_json counts_json(const facts::InputCounts& counts) {
  ordered_json json = ordered_json::object();
  for (const facts::Count& count : facts::kCounts) json[count.name] = counts.*count.member;
  return json;
}

ordered_json level_json(std::size_t number, const facts::LevelStatistics& level) {
  ordered_json json{{"level", number}};
  facts::for_each_level_field([&](const facts::LevelField& field, auto member) {
    if (field.report_name != nullptr) json[field.report_name] = std::invoke(member, level);
  });
  return json;
}

ordered_json levels_json(const std::vector<facts::LevelStatistics>& levels) {
  ordered_json json = ordered_json::array();
  for (const facts::LevelStatistics& level : levels) json.push_back(level_json(json.size(), level));
  return json;
}

// What the batch system calls the job, if there is one.
ordered_json job_json() {
  ordered_json json = ordered_json::object();
  for (const char* name : {"SLURM_JOB_ID", "SLURM_JOB_NAME", "SLURM_JOB_NUM_NODES", "SLURM_NTASKS"})
    if (const char* value = std::getenv(name)) json[name] = value;
  return json;
}

}  // namespace

Reporter::Reporter(const cluster::Communicator& ranks, const facts::BuildOptions& options,
                   const Outputs& outputs)
    : ranks_(ranks), options_(options), outputs_(outputs), begin_(now_text()) {
  hosts_ = ranks_.host_names();
  peak_memory_.assign(hosts_.size(), 0);
  ranks_.attempt([&] {
    if (!ranks_.is_root()) return;
    if (outputs_.status.is_asked_for()) replace_file(outputs_.status, status_json("running"));
    if (outputs_.report.is_asked_for() && !outputs_.report.is_stream)
      replace_file(outputs_.report, report_json(nullptr));
  });
}

void Reporter::begin_phase(const std::string& name, std::size_t task_count, std::size_t resumed_count) {
  if (!ranks_.is_root()) return;
  phases_.push_back({name, task_count, resumed_count, 0.0, {}});
  done_ = resumed_count;
  phase_begin_ = last_line_ = Clock::now();
  write_status("running");
}

void Reporter::finish_task() {
  if (!ranks_.is_root()) return;
  ++done_;
  const Clock::time_point now = Clock::now();
  if (now - last_line_ >= kLineInterval) {
    last_line_ = now;
    core::log_line(progress_line());
  }
  if (now - last_status_ >= kStatusInterval) write_status("running");
}

void Reporter::end_phase(PhaseShare mine) {
  mine.triangles = triangles_;
  mine.peak_memory_bytes = core::peak_memory_bytes();
  triangles_ = 0;
  const auto gathered = ranks_.gather(std::as_bytes(std::span(&mine, 1)));
  if (!ranks_.is_root()) return;
  Phase& phase = phases_.back();
  phase.seconds = phase_seconds();
  for (std::size_t rank = 0; rank < gathered.size(); ++rank) {
    phase.shares.push_back(core::ByteReader(gathered[rank]).get<PhaseShare>());
    peak_memory_[rank] = std::max(peak_memory_[rank], phase.shares.back().peak_memory_bytes);
  }
}

void Reporter::finish(const core::Error* failure) {
  const std::uint64_t memory = core::peak_memory_bytes();
  const auto gathered = ranks_.gather(std::as_bytes(std::span(&memory, 1)));
  for (std::size_t rank = 0; rank < gathered.size(); ++rank)
    peak_memory_[rank] = std::max(peak_memory_[rank], core::ByteReader(gathered[rank]).get<std::uint64_t>());
  ranks_.attempt([&] {
    if (ranks_.is_root()) write_last(failure);
  });
}

void Reporter::write_last(const core::Error* failure) {
  is_complete_ = failure == nullptr;
  const bool is_stopped = failure != nullptr && failure->status() == core::Status::kStopped;
  write_status(is_complete_ ? "done" : is_stopped ? "stopped" : "failed");
  if (!outputs_.report.is_asked_for()) return;
  const std::string text = report_json(failure);
  if (!outputs_.report.is_stream) {
    replace_or_warn(outputs_.report, text);
    return;
  }
  try {
    write_to_stream(outputs_.report, text);
  } catch (const core::Error& error) {
    if (failure == nullptr)
      core::fail(error.status(), "the report could not be written: {}; the build itself is done",
                 error.what());
    core::warn_line(error.what());
  }
}

void Reporter::set_input(const facts::Catalog& catalog) {
  inputs_ = catalog.files;
  counts_ = catalog.counts;
}

void Reporter::set_output(const facts::FinishedNodes& finished, std::uint64_t output_bytes) {
  levels_ = finished.levels;
  node_count_ = finished.nodes.size();
  output_bytes_ = output_bytes;
}

double Reporter::phase_seconds() const {
  return std::chrono::duration<double>(Clock::now() - phase_begin_).count();
}

std::string Reporter::progress_line() const {
  const Phase& phase = phases_.back();
  const double share = phase.tasks == 0 ? 1.0 : static_cast<double>(done_) / static_cast<double>(phase.tasks);
  const auto fresh = static_cast<double>(done_ - phase.resumed);
  const double rate = fresh / std::max(phase_seconds(), 1e-9);
  return fmt::format("{}: {:.0f} %, {} of {} tasks, {:.1f} per second, {:.0f} s left, peak memory {} MB",
                     phase.name, 100.0 * share, done_, phase.tasks, rate,
                     static_cast<double>(phase.tasks - done_) / std::max(rate, 1e-9),
                     core::peak_memory_bytes() >> 20);
}

void Reporter::write_status(const char* state) {
  last_status_ = Clock::now();
  if (outputs_.status.is_asked_for()) replace_or_warn(outputs_.status, status_json(state));
}

void Reporter::replace_or_warn(const core::OutputTarget& file, const std::string& text) {
  try {
    replace_file(file, text);
  } catch (const std::exception& error) {
    if (!has_warned_) core::warn("{}: cannot be written: {}", file.path.string(), error.what());
    has_warned_ = true;
  }
}

std::string Reporter::status_json(const char* state) const {
  ordered_json json{{"format", "colossus-status"},
                    {"version", 1},
                    {"state", state},
                    {"updated", now_text()},
                    {"host", hosts_.front()},
                    {"process", ::getpid()},
                    {"attempt", attempt_},
                    {"seconds", core::elapsed_seconds()},
                    {"peak_memory_bytes", core::peak_memory_bytes()}};
  if (!phases_.empty())
    json["phase"] = {{"name", phases_.back().name},
                     {"tasks", phases_.back().tasks},
                     {"done", done_},
                     {"seconds", phase_seconds()}};
  return text_of(json);
}

std::string Reporter::report_json(const core::Error* failure) const {
  ordered_json json{{"format", "colossus-report"}, {"version", 1}};
  json["state"] = is_complete_ ? "done" : failure == nullptr ? "running" : "failed";
  if (failure != nullptr && failure->status() == core::Status::kStopped) json["state"] = "stopped";
  json["exit_status"] = failure == nullptr ? 0 : static_cast<int>(failure->status());
  json["message"] = failure == nullptr ? "" : failure->what();
  json["program"] = {{"name", "colossus"},
                     {"version", core::release_version()},
                     {"commit", build_commit()},
                     {"build", build_id()},
                     {"compiler", kCompiler}};
  json["command"] = options_.command;
  std::error_code unknown;  // the folder may have been removed
  json["folder"] = std::filesystem::current_path(unknown).string();
  json["begin"] = begin_;
  json["end"] = now_text();
  json["seconds"] = core::elapsed_seconds();
  json["attempt"] = attempt_;
  json["hosts"] = hosts_;
  json["job"] = job_json();
  json["options"] = options_json(options_);
  json["inputs"] = ordered_json::array();
  for (const facts::InputFile& file : inputs_)
    json["inputs"].push_back({{"name", file.name}, {"bytes", file.bytes}, {"hash", file.hash}});
  json["counts"] = counts_json(counts_);
  json["triangles_per_second"] =
      is_complete_ ? static_cast<double>(counts_.triangles) / core::elapsed_seconds() : 0.0;
  json["estimate"] = {{"memory_bytes_per_rank", estimate_.memory_bytes_per_rank},
                      {"scratch_bytes", estimate_.scratch_bytes},
                      {"output_bytes", estimate_.output_bytes},
                      {"free_scratch_bytes", estimate_.free_scratch_bytes},
                      {"free_output_bytes", estimate_.free_output_bytes}};
  json["used"] = {{"peak_memory_bytes", peak_memory_},
                  {"scratch_bytes", most_scratch_bytes_},
                  {"output_bytes", output_bytes_}};
  json["phases"] = ordered_json::array();
  for (const Phase& phase : phases_) {
    ordered_json entry{
        {"name", phase.name}, {"tasks", phase.tasks}, {"resumed", phase.resumed}, {"seconds", phase.seconds}};
    if (!phase.shares.empty()) {
      entry["work_seconds"] = spread(phase.shares, [](const PhaseShare& s) { return s.work_seconds; });
      entry["rank_tasks"] = spread(phase.shares, [](const PhaseShare& s) { return s.tasks; });
      entry["triangles"] = spread(phase.shares, [](const PhaseShare& s) { return s.triangles; });
      entry["scratch_bytes"] = spread(phase.shares, [](const PhaseShare& s) { return s.scratch_bytes; });
      entry["peak_memory_bytes"] =
          spread(phase.shares, [](const PhaseShare& s) { return s.peak_memory_bytes; });
    }
    json["phases"].push_back(std::move(entry));
  }
  json["levels"] = levels_json(levels_);
  json["output"] = {{"path", options_.output.string()}, {"bytes", output_bytes_}, {"nodes", node_count_}};
  return text_of(json);
}

}  // namespace colossus::pipeline::run
