#include <functional>
#include <type_traits>

#include "cli/commands.hpp"
#include "cluster/session.hpp"
#include "core/log.hpp"
#include "pipeline/build.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/schemes.hpp"

namespace colossus::cli {
namespace {

std::string codec_names() {
  std::string names;
  for (const codec::Codec& codec : codec::codecs())
    names += fmt::format("{}{}", names.empty() ? "" : ", ", codec.name);
  return names;
}

std::string help_of(const pipeline::facts::Option& option) {
  const std::string_view name = option.name;
  if (name == "scheme") return fmt::format("{}: {}", option.help, pipeline::schemes_text());
  if (name == "codec") return fmt::format("{}: {}", option.help, codec_names());
  return option.scheme == nullptr ? option.help : fmt::format("Of {}: {}", option.scheme, option.help);
}

// One overload for each type that options have.
void add_option(CLI::App& command, const pipeline::facts::Option& option, bool& value) {
  command.add_flag(flag_of(option), value, help_of(option));
}

void add_option(CLI::App& command, const pipeline::facts::Option& option, std::vector<std::string>& words) {
  command.add_option(option.name, words, help_of(option))->required();
}

void add_option(CLI::App& command, const pipeline::facts::Option& option, std::filesystem::path& output) {
  command.add_option("-o," + flag_of(option), output, help_of(option))->required();
}

template <typename T>
void add_option(CLI::App& command, const pipeline::facts::Option& option, std::optional<T>& value) {
  command.add_option(flag_of(option), value, help_of(option));
}

template <typename T>
void add_option(CLI::App& command, const pipeline::facts::Option& option, T& value) {
  CLI::Option* added = command.add_option(flag_of(option), value, help_of(option))->capture_default_str();
  if constexpr (std::is_unsigned_v<T>) added->check(count_from(0));
}

}  // namespace

void add_build(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<pipeline::facts::BuildOptions>();
  CLI::App* command = app.add_subcommand("build", "Build a container; run it alone, or under mpirun or srun");
  options->scheme = pipeline::schemes().front()->name;
  pipeline::facts::for_each_option([&](const pipeline::facts::Option& option, auto member) {
    if (option.help != nullptr) add_option(*command, option, std::invoke(member, *options));
  });
  command->get_option("--tolerance")->excludes(command->get_option("--position-bits"));
  command->callback([&chosen, options] {
    chosen = [options](int& argc, char**& argv) {
      return cluster::run_ranks(argc, argv, [&](cluster::Communicator& ranks) {
        cluster::refuse_lone_start(ranks);
        options->command.assign(argv, argv + argc);
        const pipeline::BuildReport report = pipeline::build(ranks, *options);
        if (report.is_dry_run) {
          core::log("done: nothing was built (--dry-run)");
          return 0;
        }
        core::log("done: {} triangles into {} nodes, {} bytes: {}", report.input_triangles, report.nodes,
                  report.output_bytes, options->output.string());
        return 0;
      });
    };
  });
}

}  // namespace colossus::cli
