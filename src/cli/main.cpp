// The colossus program: parses the command line, runs one subcommand, and turns errors into exit statuses.
#include <csignal>
#include <cstdio>

#include "cli/commands.hpp"
#include "core/error.hpp"
#include "core/version.hpp"

int main(int argc, char** argv) {
  using colossus::core::Status;
  // A limit on the size of files (ulimit -f) then is an error like a full disk, with a message.
  std::signal(SIGXFSZ, SIG_IGN);
  // And a reader of a pipe that goes away is an error of writing.
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app{
      "Colossus turns gigantic triangle meshes into multiresolution containers that readers open "
      "out-of-core."};
  app.set_version_flag("--version", colossus::core::release_version());
  app.require_subcommand(1);
  colossus::cli::Action chosen;
  colossus::cli::add_build(app, chosen);
  colossus::cli::add_info(app, chosen);
  colossus::cli::add_verify(app, chosen);
  colossus::cli::add_extract(app, chosen);
  colossus::cli::add_synth(app, chosen);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(Status::kUsage);
  }
  try {
    return chosen(argc, argv);
  } catch (...) {
    const colossus::core::Error error = colossus::core::error_of_current_exception();
    std::fprintf(stderr, "colossus: %s\n", error.what());
    return static_cast<int>(error.status());
  }
}
