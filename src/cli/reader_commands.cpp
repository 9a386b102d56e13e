// info, verify and extract: what a user does with a finished container.
#include <unistd.h>

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "core/error.hpp"
#include "core/file.hpp"
#include "core/log.hpp"
#include "exporters/ply.hpp"
#include "input/load.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/run/inputs.hpp"
#include "reader/info.hpp"
#include "reader/open.hpp"
#include "verify/verify.hpp"

namespace colossus::cli {
namespace {

std::unique_ptr<reader::access::Statue> open_named(const std::string& path) {
  core::check_input_name(path);
  return reader::open(path);
}

constexpr std::uint64_t kMostLevel = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kMostSamples = 10'000'000;  // they are held in memory

struct VerifyArguments {
  std::string container;
  std::vector<std::string> against;
  std::size_t samples = verify::measure::VerifyOptions{}.samples_per_node;
  bool drop_textures = false;
  bool is_lenient = false;
};

int verify_container(const VerifyArguments& arguments) {
  const auto statue = open_named(arguments.container);
  verify::measure::VerifyOptions options;
  options.samples_per_node = arguments.samples;
  input::LoadedMesh input;
  verify::measure::Surface surface;
  if (!arguments.against.empty()) {
    pipeline::run::spared_inputs(arguments.against);  // refuses names that mean a descriptor
    input = input::load_mesh(arguments.against, {arguments.drop_textures, arguments.is_lenient});
    surface = {input.positions, input.triangles};
    options.against = &surface;
  }
  const verify::measure::VerifyReport report = verify::verify(*statue, options);
  print(verify::measure::to_text(report));
  if (!report.is_ok())
    core::fail(core::Status::kBadData, "{}: verify found {} faults", arguments.container, report.total());
  return 0;
}

struct ExtractArguments {
  std::string container;
  std::string output;
  std::optional<std::uint32_t> level;
  std::optional<double> error;
  std::optional<std::uint64_t> triangles;
  std::vector<double> eye;
  std::optional<double> kappa;
};

reader::access::CutRequest request_of(const ExtractArguments& arguments) {
  using namespace reader::access;
  if (arguments.level) return AtLevel{*arguments.level};
  if (arguments.error) return WithError{*arguments.error};
  if (arguments.triangles) return WithTriangles{*arguments.triangles};
  return Eye{{arguments.eye[0], arguments.eye[1], arguments.eye[2]}, arguments.kappa};
}

int extract_cut(const ExtractArguments& arguments, const core::OutputTarget& target) {
  const auto statue = open_named(arguments.container);
  const reader::access::Extraction cut = statue->extract(request_of(arguments));
  if (!cut.warning.empty()) core::warn("{}", cut.warning);
  for (std::size_t level = 0; level < cut.parts_by_level.size(); ++level)
    if (cut.parts_by_level[level] > 0)
      core::log("level {}: {} {}", level, cut.parts_by_level[level], statue->name_of_parts());
  const exporters::WrittenPly result = exporters::write_ply(cut.mesh, target);
  core::log("{}: {} vertices, {} triangles{}", arguments.output, result.vertices, result.triangles,
            result.has_doubles ? ", positions as doubles" : "");
  return 0;
}

}  // namespace

void add_info(CLI::App& app, Action& chosen) {
  struct Arguments {
    std::string container;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("info", "Show what is inside a container, per level");
  command->add_option("container", arguments->container, "The container")->required();
  command->add_flag("--json", arguments->json, "As JSON");
  command->callback([&chosen, arguments] {
    chosen = [arguments](int&, char**&) {
      const auto statue = open_named(arguments->container);
      print(arguments->json ? reader::info_json(*statue) : reader::info_text(*statue));
      return 0;
    };
  });
}

void add_verify(CLI::App& app, Action& chosen) {
  auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* command = app.add_subcommand(
      "verify", "Check a container: bytes, structure, every face or parent map, every uniform cut");
  command->add_option("container", arguments->container, "The container")->required();
  command->add_option(
      "--against", arguments->against,
      "The input files: compare numbers, bounds and area, and by sampling each level both ways");
  command->add_option("--samples", arguments->samples, "Samples per node with --against")
      ->check(count_from(1, kMostSamples))
      ->capture_default_str();
  command->add_flag("--drop-textures", arguments->drop_textures, "As for build");
  command->add_flag("--lenient", arguments->is_lenient, pipeline::facts::kLenientHelp);
  command->callback(
      [&chosen, arguments] { chosen = [arguments](int&, char**&) { return verify_container(*arguments); }; });
}

void add_extract(CLI::App& app, Action& chosen) {
  auto arguments = std::make_shared<ExtractArguments>();
  CLI::App* command = app.add_subcommand("extract", "Write a conforming cut as PLY");
  command->add_option("container", arguments->container, "The container")->required();
  command->add_option("-o,--output", arguments->output, "The PLY file to write")->required();
  CLI::Option_group* cut = command->add_option_group("cut", "Which cut");
  cut->add_option("--level", arguments->level, "Every node of this level, or the leaf above it")
      ->check(count_from(0, kMostLevel));
  cut->add_option("--error", arguments->error,
                  "The coarsest cut with at most this error, in the input's units")
      ->check(length());
  cut->add_option("--triangles", arguments->triangles,
                  "The finest cut of a fixed order with at most so many triangles")
      ->check(count_from(0));
  CLI::Option* eye =
      cut->add_option("--eye", arguments->eye,
                      "The view-dependent cut for an eye at X,Y,Z, in the input's units; levels go over "
                      "into each other as the scheme has it")
          ->delimiter(',')
          ->expected(3);
  cut->require_option(1);
  command
      ->add_option(
          "--kappa", arguments->kappa,
          "With --eye: what is nearer than so many times a node's side is refined; default 2, or what "
          "the scheme needs at least")
      ->needs(eye);
  command->callback([&chosen, arguments] {
    chosen = [arguments](int&, char**&) {
      const core::SparedFile container{"the container", arguments->container};
      const core::OutputRequest request{"-o", arguments->output, core::OutputKind::kFileOrStream};
      const core::OutputTarget target =
          core::plan_outputs(std::span(&container, 1), std::span(&request, 1)).front();
      if (target.is_same_as(STDOUT_FILENO)) core::keep_log_off_stdout();
      return extract_cut(*arguments, target);
    };
  });
}

}  // namespace colossus::cli
