#include <functional>
#include <type_traits>

#include "cli/commands.hpp"
#include "cluster/session.hpp"
#include "core/log.hpp"
#include "input/formats.hpp"
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
  using pipeline::nodes::Scheme;
  const std::string_view name = option.name;
  if (name == "inputs") return fmt::format("{} {}", input::format_names(), option.help);
  if (name == "scheme")
    return fmt::format("{}: {}", option.help, pipeline::schemes_text(&Scheme::description));
  if (name == "leaf_triangles")
    return fmt::format("{} ({})", option.help, pipeline::schemes_text(&Scheme::leaf_triangles_of));
  if (name == "position_bits")
    return fmt::format("{} ({})", option.help, pipeline::schemes_text(&Scheme::position_bits_of));
  if (name == "codec") return fmt::format("{}: {}", option.help, codec_names());
  return option.help;
}

// One overload for each type that options have.
void add_option(CLI::App& command, const pipeline::facts::Option& option, bool& value) {
  command.add_flag(pipeline::facts::flag_of(option.name), value, help_of(option));
}

void add_option(CLI::App& command, const pipeline::facts::Option& option, std::vector<std::string>& words) {
  command.add_option(option.name, words, help_of(option))->required();
}

void add_option(CLI::App& command, const pipeline::facts::Option& option, std::filesystem::path& output) {
  command.add_option("-o," + pipeline::facts::flag_of(option.name), output, help_of(option))->required();
}

template <typename T>
void add_option(CLI::App& command, const pipeline::facts::Option& option, std::optional<T>& value) {
  command.add_option(pipeline::facts::flag_of(option.name), value, help_of(option));
}

template <typename T>
void add_option(CLI::App& command, const pipeline::facts::Option& option, T& value) {
  CLI::Option* added = command.add_option(pipeline::facts::flag_of(option.name), value, help_of(option))
                           ->capture_default_str();
  if constexpr (std::is_unsigned_v<T>) added->check(count_from(0));
}

using SharedOptions = std::shared_ptr<pipeline::facts::BuildOptions>;

// An option that schemes may have in common.
void add_option(CLI::App& command, const pipeline::nodes::Scheme& scheme,
                const pipeline::facts::SchemeOption& option, const SharedOptions& options) {
  const std::string flag = pipeline::facts::flag_of(option.name);
  const std::string help = fmt::format("Of {}: {}", scheme.name, option.help);
  if (CLI::Option* other = command.get_option_no_throw(flag)) {
    other->description(fmt::format("{}. {}", other->get_description(), help));
    return;
  }
  const auto add = [&]<typename T>(const T&) {
    const auto keep = [options, name = option.name](const T& value) { options->of_scheme[name] = value; };
    CLI::Option* added = nullptr;
    if constexpr (std::is_same_v<T, bool>)
      added = command.add_flag_callback(
          flag, [keep] { keep(true); }, help);
    else
      added = command.add_option_function<T>(flag, keep, help);
    if (option.fallback && !std::is_same_v<T, bool>)
      added->default_str(pipeline::facts::text_of(*option.fallback));
  };
  std::visit(add, option.type);
}

// Files, what shapes the bytes for all schemes and for some, and how the build is run.
void add_options(CLI::App& command, const SharedOptions& options) {
  using namespace pipeline::facts;
  const auto add = [&](const Option& option, auto member) {
    if (option.help != nullptr) add_option(command, option, std::invoke(member, *options));
  };
  for_each_file_option(add);
  for_each_shaping_option(add);
  for (const pipeline::nodes::Scheme* scheme : pipeline::schemes())
    for (const SchemeOption& option : scheme->options)
      if (option.help != nullptr) add_option(command, *scheme, option, options);
  for_each_run_option(add);
}

}  // namespace

void add_build(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<pipeline::facts::BuildOptions>();
  CLI::App* command = app.add_subcommand("build", "Build a container; run it alone, or under mpirun or srun");
  options->scheme = pipeline::schemes().front()->name;
  add_options(*command, options);
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
