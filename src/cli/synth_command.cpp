#include "cli/commands.hpp"
#include "core/log.hpp"
#include "input/load.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/run/inputs.hpp"
#include "synth/synth.hpp"

namespace colossus::cli {
namespace {

struct SynthArguments {
  synth::SynthOptions options;
  std::optional<std::string> base;
  bool is_lenient = false;
  bool no_colors = false;
};

int run(SynthArguments arguments) {
  arguments.options.colors = !arguments.no_colors;
  const std::string output = arguments.options.output.string();
  std::vector<core::SparedFile> spared;
  if (arguments.base) spared = pipeline::run::spared_inputs(std::span(&*arguments.base, 1));
  const core::OutputRequest request{"-o", arguments.options.output, core::OutputKind::kFile};
  arguments.options.output = core::plan_outputs(spared, std::span(&request, 1)).front().path;
  const double start = core::elapsed_seconds();
  synth::SynthReport report;
  if (!arguments.base) {
    report = synth::synthesize(arguments.options);
  } else {
    input::LoadedMesh loaded =
        input::load_mesh(std::span(&*arguments.base, 1), {.is_lenient = arguments.is_lenient});
    synth::BaseMesh base;
    base.name = *arguments.base;
    base.positions = std::move(loaded.positions);
    base.triangles = std::move(loaded.triangles);
    for (const auto& c : loaded.colors) base.colors.push_back({c[0], c[1], c[2]});
    report = synth::synthesize(arguments.options, base);
  }
  const double seconds = core::elapsed_seconds() - start;
  core::log("{}: {} vertices, {} triangles, {:.1f} million triangles per second", output, report.vertices,
            report.triangles, static_cast<double>(report.triangles) / 1e6 / seconds);
  return 0;
}

}  // namespace

void add_synth(CLI::App& app, Action& chosen) {
  auto arguments = std::make_shared<SynthArguments>();
  CLI::App* command = app.add_subcommand("synth", "Write a closed, scan-like statue of any size");
  command->add_option("-o,--output", arguments->options.output, "The PLY file to write")->required();
  command->add_option("--triangles", arguments->options.triangles, "About how many triangles")
      ->check(count_from(1))
      ->capture_default_str();
  command->add_option("--seed", arguments->options.seed, "Another seed, another statue")
      ->check(count_from(0))
      ->capture_default_str();
  command->add_option(
      "--base", arguments->base,
      "A mesh to sculpt instead of the built-in statue, subdivided to any size beyond its own");
  command->add_flag("--lenient", arguments->is_lenient, pipeline::facts::kLenientHelp);
  command->add_flag("--shuffle", arguments->options.shuffle,
                    "Write vertices and faces in an order without locality");
  command->add_flag("--no-colors", arguments->no_colors, "Without vertex colours");
  command->add_flag("--normals", arguments->options.normals, "With vertex normals");
  command->callback(
      [&chosen, arguments] { chosen = [arguments](int&, char**&) { return run(*arguments); }; });
}

}  // namespace colossus::cli
