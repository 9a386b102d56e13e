#include "pipeline/run/outputs.hpp"

#include <unistd.h>

#include <limits>

#include "core/log.hpp"
#include "pipeline/run/inputs.hpp"
#include "pipeline/run/workspace.hpp"
#include "scratch/directory.hpp"

namespace colossus::pipeline::run {
namespace {

// As long as a path in a scratch folder can become.
std::size_t longest_scratch_path() {
  constexpr std::uint16_t kMost = std::numeric_limits<std::uint16_t>::max();
  const scratch::FileId file{kMost, kMost, kMost - 1};
  return path_of(scratch::folder_of_attempt({}, kMost), file).string().size();
}

Outputs plan(const facts::BuildOptions& options) {
  using core::OutputKind;
  std::vector<core::OutputRequest> requests{
      {"-o", options.output, OutputKind::kFile},
      {options.scratch ? "--scratch" : "the scratch folder", scratch_of(options), OutputKind::kFolder,
       longest_scratch_path()}};
  if (options.status_file) requests.push_back({"--status", *options.status_file, OutputKind::kFile});
  if (options.report_file) requests.push_back({"--report", *options.report_file, OutputKind::kFileOrStream});
  const std::vector<core::OutputTarget> targets = core::plan_outputs(spared_inputs(options.inputs), requests);
  Outputs outputs{targets[0], {}, {}, targets[1].path};
  std::size_t next = 2;
  if (options.status_file) outputs.status = targets[next++];
  if (options.report_file) outputs.report = targets[next];
  return outputs;
}

}  // namespace

std::filesystem::path scratch_of(const facts::BuildOptions& options) {
  return options.scratch ? *options.scratch : std::filesystem::path(options.output.string() + ".scratch");
}

Outputs plan_outputs(const cluster::Communicator& ranks, const facts::BuildOptions& options) {
  Outputs outputs;
  ranks.attempt([&] {
    if (ranks.is_root()) outputs = plan(options);
  });
  const std::string text = outputs.scratch.string();
  std::vector<char> letters(text.begin(), text.end());
  broadcast_values(ranks, letters);
  outputs.scratch = std::string(letters.begin(), letters.end());
  if (outputs.report.is_asked_for() && outputs.report.is_same_as(STDOUT_FILENO)) core::keep_log_off_stdout();
  return outputs;
}

}  // namespace colossus::pipeline::run
