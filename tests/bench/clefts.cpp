// clefts shifted|unshifted INPUT CONTAINER [LEAF_TRIANGLES]: builds a container of blocks and prints, per
// level, the density of triangles near the borders of blocks over that of the rest of their cubes: of borders
// that were locked while this level was made, and of those that were locked earlier, while a finer one was.
// The program builds blocks that are shifted by half a block; not shifted, the borders of all levels lie on
// top of each other.
#include "verify/blocks/clefts.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "cluster/session.hpp"
#include "core/log.hpp"
#include "pipeline/blocks/scheme.hpp"
#include "pipeline/build.hpp"

namespace {

using namespace colossus;

void print_level(const reader::blocks::Statue& statue, std::uint32_t level, bool has_shifted_blocks) {
  const reader::access::RowRange rows = statue.rows_of_level(level);
  verify::blocks::EdgeLengths lengths;
  for (reader::access::RowIndex row = rows.first; row < rows.last; ++row) {
    const verify::blocks::EdgeLengths own = verify::blocks::edge_lengths(statue.load(row));
    lengths.sum += own.sum;
    lengths.count += own.count;
  }
  verify::blocks::CleftCounts counts;
  for (reader::access::RowIndex row = rows.first; row < rows.last; ++row)
    counts.add(verify::blocks::count_clefts(statue, static_cast<int>(level), statue.load(row), lengths.mean(),
                                            has_shifted_blocks));
  const auto cell = [](const std::optional<double>& density) {
    return density ? fmt::format("{:.3f}", *density) : "-";
  };
  const verify::measure::CleftDensities densities = counts.densities();
  fmt::print("{:5} {:10} {:>8} {:>8}\n", level, lengths.count / 3, cell(densities.locked),
             cell(densities.earlier));
}

void run(const cluster::Communicator& ranks, const pipeline::facts::BuildOptions& options) {
  core::set_log_enabled(false);
  pipeline::build(ranks, options);
  if (ranks.rank() != 0) return;
  const reader::blocks::Statue statue(options.output);
  fmt::print("level  triangles   locked  earlier\n");
  for (std::uint32_t level = statue.deepest_level(); level-- > 0;)
    print_level(statue, level, pipeline::blocks::options_of(options).has_shifted_blocks);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view shift = argc == 4 || argc == 5 ? argv[1] : "";
  if (shift != "shifted" && shift != "unshifted") {
    fmt::print(stderr, "usage: clefts shifted|unshifted INPUT CONTAINER [LEAF_TRIANGLES]\n");
    return 2;
  }
  pipeline::facts::BuildOptions options;
  options.inputs = {argv[2]};
  options.output = argv[3];
  options.scheme = hierarchy::kBlocks;
  options.of_scheme["shifted_blocks"] = shift == "shifted";
  if (argc == 5) options.leaf_triangles = std::strtoull(argv[4], nullptr, 10);
  return cluster::run_ranks(argc, argv, [&](cluster::Communicator& ranks) {
    run(ranks, options);
    return 0;
  });
}
