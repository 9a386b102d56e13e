#include "pipeline/blocks/fullest_block.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace colossus::pipeline::blocks {

double most_in_block(const ingest::Occupancy& occupancy, int level, int size) {
  const double in_cells = std::ldexp(size, ingest::Occupancy::kLevel - level);
  const int side = std::max(static_cast<int>(in_cells), 1);
  std::uint64_t most = 0;
  std::unordered_map<std::uint32_t, std::uint64_t> sums;
  for (const ingest::Occupancy::Cell& cell : occupancy.cells) {
    std::uint32_t key = 0;
    for (const int at : cell.at) key = key << 9 | static_cast<std::uint32_t>((at + side / 2) / side);
    most = std::max(most, sums[key] += cell.vertices);
  }
  return static_cast<double>(most) * std::min(in_cells * in_cells, 1.0);
}

}  // namespace colossus::pipeline::blocks
