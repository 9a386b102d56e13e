// The subcommands of the program. Each adds its options to the parser and fills in what runs them.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <string>

namespace colossus::cli {

// What the command line has chosen: given the arguments of main(), which MPI may read, it returns the exit
// status.
using Action = std::function<int(int& argc, char**& argv)>;

// For options that take a count. CLI11 would read -1 as the largest number, and cut down larger ones.
CLI::Validator count_from(std::uint64_t least, std::uint64_t most = ~std::uint64_t{0});

// For options that take a length, which "nan" and "inf" are not.
CLI::Validator length();

// To stdout. Throws Error(kNoResources) or Error(kIo) when it cannot be written.
void print(const std::string& text);

void add_build(CLI::App& app, Action& chosen);
void add_synth(CLI::App& app, Action& chosen);
void add_info(CLI::App& app, Action& chosen);
void add_verify(CLI::App& app, Action& chosen);
void add_extract(CLI::App& app, Action& chosen);

}  // namespace colossus::cli
