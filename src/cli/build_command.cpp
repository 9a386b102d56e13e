#include "cli/commands.hpp"
#include "cluster/session.hpp"
#include "core/duration.hpp"
#include "core/log.hpp"
#include "pipeline/build.hpp"
#include "pipeline/schemes.hpp"

namespace colossus::cli {
namespace {

double seconds_of(const std::string& time_limit) {
  const std::optional<double> seconds = core::parse_duration(time_limit);
  if (!seconds)
    core::fail(core::Status::kUsage,
               "--time-limit {} is no time; write it like 90s, 45m, 3h50m or 1-02:00:00", time_limit);
  return *seconds;
}

std::string codec_help() {
  std::string names;
  for (const codec::Codec& codec : codec::codecs())
    names += fmt::format("{}{}", names.empty() ? "" : ", ", codec.name);
  return "How nodes are stored: " + names;
}

}  // namespace

void add_build(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<pipeline::facts::BuildOptions>();
  CLI::App* command = app.add_subcommand("build", "Build a container; run it alone, or under mpirun or srun");
  command
      ->add_option("inputs", options->inputs, "PLY, OBJ, STL or OFF files, or @list.txt; together one statue")
      ->required();
  command->add_option("-o,--output", options->output, "The container to write, e.g. statue.h5")->required();
  command->add_option("--scratch", options->scratch,
                      "Folder for temporary files, to be created, or empty; default: <output>.scratch");
  command->add_flag("--resume", options->resume,
                    "Continue the build that was interrupted; without one, begin a new one");
  auto time_limit = std::make_shared<std::string>();
  command->add_option("--time-limit", *time_limit,
                      "Stop in order after this time, e.g. 90s, 45m, 3h50m, 1-02:00:00; then see --resume");
  options->scheme = pipeline::schemes().front()->name;
  command->add_option("--scheme", options->scheme, pipeline::schemes_text())->capture_default_str();
  command
      ->add_option("--leaf-triangles", options->leaf_triangles,
                   "Most triangles per leaf tetrahedron; of blocks: most on average per cube")
      ->check(count_from(0))
      ->capture_default_str();
  auto* bits =
      command->add_option("--position-bits", options->position_bits, "Bits per barycentric weight, 8 to 16")
          ->capture_default_str();
  command
      ->add_option("--tolerance", options->tolerance,
                   "Largest quantisation error of the finest level in the input's units; chooses the bits")
      ->excludes(bits);
  command->add_option("--codec", options->codec, codec_help())->capture_default_str();
  command->add_option("--levels", options->levels,
                      "Of blocks: the deepest level, instead of the one that fits");
  command->add_option("--block-size", options->block_size, "Of blocks: cubes along a block; default: 4");
  command
      ->add_option("--color-weight", options->color_weight,
                   "Of blocks: mean edge lengths that a full change of colour counts when simplifying")
      ->capture_default_str();
  command->add_flag("--drop-textures", options->drop_textures,
                    "Accept texture coordinates and materials, and drop them");
  command->add_flag("--lenient", options->is_lenient, kLenientHelp);
  command->add_flag("--keep-outliers", options->keep_outliers,
                    "Go on although a few far corners make the lattice coarser than the triangles");
  command->add_option(
      "--memory", options->memory,
      "Most memory per rank, e.g. 512M or 2G, at least 256M; default: its share of the host's");
  command->add_flag("--dry-run", options->is_dry_run,
                    "Read the input, tell what the build will need, and end");
  command->add_option("--status", options->status_file,
                      "Keep how far the build is in this file, a small JSON");
  command->add_option("--report", options->report_file,
                      "Write what was done, how long it took and what it used to this file, a JSON");
  command->callback([&chosen, options, time_limit] {
    chosen = [options, time_limit](int& argc, char**& argv) {
      return cluster::run_ranks(argc, argv, [&](cluster::Communicator& ranks) {
        cluster::refuse_lone_start(ranks);
        options->command.assign(argv, argv + argc);
        if (!time_limit->empty()) options->time_limit = seconds_of(*time_limit);
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
