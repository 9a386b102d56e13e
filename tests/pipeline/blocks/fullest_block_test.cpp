#include "pipeline/blocks/fullest_block.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "pipeline/test_build.hpp"

namespace colossus::pipeline::blocks {
namespace {

using Cell = std::array<int, 3>;

std::map<Cell, std::uint64_t> random_cells(std::mt19937_64& random, std::size_t count) {
  std::map<Cell, std::uint64_t> cells;
  for (std::size_t i = 0; i < count; ++i)
    cells[{static_cast<int>(random() % 128), static_cast<int>(random() % 128),
           static_cast<int>(random() % 128)}] = 1 + random() % 1000;
  return cells;
}

ingest::Occupancy occupancy_of(const std::map<Cell, std::uint64_t>& cells) {
  ingest::Occupancy occupancy;
  for (const auto& [at, vertices] : cells)
    occupancy.cells.push_back({{static_cast<std::uint8_t>(at[0]), static_cast<std::uint8_t>(at[1]),
                                static_cast<std::uint8_t>(at[2])},
                               0,
                               static_cast<std::uint32_t>(vertices)});
  return occupancy;
}

// Blocks of `size` cubes lie half a block to the left of its multiples.
TEST(FullestBlock, IsThatWithMostVertices) {
  std::mt19937_64 random(test_seed());
  const auto cells = random_cells(random, 5000);
  const ingest::Occupancy occupancy = occupancy_of(cells);
  for (int level = 0; level <= 7; ++level)
    for (const int size : {4, 8, 16, 32}) {
      const int side = size << (7 - level);
      std::uint64_t most = 0;
      std::map<Cell, std::uint64_t> blocks;
      for (const auto& [at, vertices] : cells) {
        Cell block;
        for (std::size_t k = 0; k < 3; ++k)
          block[k] = static_cast<int>(std::floor((at[k] + side / 2.0) / side));
        most = std::max(most, blocks[block] += vertices);
      }
      EXPECT_EQ(most_in_block(occupancy, level, size), static_cast<double>(most)) << level << " " << size;
    }
}

TEST(FullestBlock, BelowItsCellsBlocksHaveWhatASurfaceHas) {
  const ingest::Occupancy occupancy = occupancy_of({{{3, 4, 5}, 1600}, {{100, 4, 5}, 100}});
  EXPECT_EQ(most_in_block(occupancy, 9, 4), 1600.0);
  EXPECT_EQ(most_in_block(occupancy, 10, 4), 400.0);
  EXPECT_EQ(most_in_block(occupancy, 11, 4), 100.0);
  EXPECT_EQ(most_in_block(ingest::Occupancy{}, 5, 4), 0.0);
}

}  // namespace
}  // namespace colossus::pipeline::blocks
