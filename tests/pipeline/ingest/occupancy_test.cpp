#include "pipeline/ingest/occupancy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "pipeline/test_build.hpp"

namespace colossus::pipeline::ingest {
namespace {

using Cell = std::array<int, 3>;

std::map<Cell, std::uint64_t> random_cells(std::mt19937_64& random, std::size_t count) {
  std::map<Cell, std::uint64_t> cells;
  for (std::size_t i = 0; i < count; ++i)
    cells[{static_cast<int>(random() % 128), static_cast<int>(random() % 128),
           static_cast<int>(random() % 128)}] = 1 + random() % 1000;
  return cells;
}

Occupancy occupancy_of(const std::map<Cell, std::uint64_t>& cells) {
  Occupancy occupancy;
  for (const auto& [at, vertices] : cells)
    occupancy.cells.push_back({{static_cast<std::uint8_t>(at[0]), static_cast<std::uint8_t>(at[1]),
                                static_cast<std::uint8_t>(at[2])},
                               0,
                               static_cast<std::uint32_t>(vertices)});
  return occupancy;
}

TEST(Occupancy, CountsTheCubesOfEachLevel) {
  std::mt19937_64 random(test_seed());
  for (const std::size_t count : {1, 10, 1000, 20'000}) {
    const auto cells = random_cells(random, count);
    const Occupancy occupancy = occupancy_of(cells);
    for (int level = 0; level <= 7; ++level) {
      std::set<Cell> cubes;
      for (const auto& [at, vertices] : cells)
        cubes.insert({at[0] >> (7 - level), at[1] >> (7 - level), at[2] >> (7 - level)});
      EXPECT_EQ(occupancy.cubes_at(level), static_cast<double>(cubes.size()));
    }
    for (int level = 8; level < 20; ++level)
      EXPECT_EQ(occupancy.cubes_at(level), 4.0 * occupancy.cubes_at(level - 1)) << "as many as a surface has";
  }
  EXPECT_EQ(Occupancy{}.cubes_at(3), 0.0);
}

TEST(CountOccupancy, IsACountOfTheVerticesInTheBounds) {
  std::mt19937_64 random(test_seed());
  std::normal_distribution<double> normal;
  std::vector<MadeUpFile> files(2);
  for (MadeUpFile& file : files)
    for (int i = 0; i < 30'000; ++i)
      file.positions.push_back({normal(random), normal(random), normal(random)});
  const CommonFolder folder;
  const TestBuild build(folder);
  facts::Catalog catalog = store_files(build.workspace(), files, 1000, 1000);
  // Some vertices, which no triangle uses, lie beyond.
  catalog.bounds.add({-2.0, -2.0, -2.0});
  catalog.bounds.add({2.0, 2.0, 2.0});
  catalog.lattice = geometry::Lattice::fit(catalog.bounds);
  const Occupancy occupancy = count_occupancy(build.workspace(), catalog);
  if (!world().is_root()) return;
  std::map<Cell, std::uint64_t> expected;
  for (const MadeUpFile& file : files)
    for (const auto& position : file.positions) {
      if (!catalog.bounds.contains(position)) continue;
      const geometry::Point p = catalog.lattice.input_vertex(position);
      ++expected[{p.x >> 23, p.y >> 23, p.z >> 23}];
    }
  std::map<Cell, std::uint64_t> counted;
  for (const Occupancy::Cell& cell : occupancy.cells)
    counted[{cell.at[0], cell.at[1], cell.at[2]}] += cell.vertices;
  EXPECT_EQ(counted.size(), occupancy.cells.size()) << "each cell once";
  EXPECT_TRUE(counted == expected);
}

// A task has a million vertices, so that there are several.
TEST(CountOccupancy, AddsUpWhatTasksHaveCounted) {
  MadeUpFile file;
  for (int i = 0; i < 1'200'000; ++i) file.positions.push_back({i % 1000 * 1.0, i / 1000 * 1.0, 0.0});
  const CommonFolder folder;
  const TestBuild build(folder);
  facts::Catalog catalog = store_files(build.workspace(), {file}, 130'000, 1000);
  fit_lattice(catalog, {file});
  const Occupancy occupancy = count_occupancy(build.workspace(), catalog);
  if (!world().is_root()) return;
  std::uint64_t sum = 0;
  for (const Occupancy::Cell& cell : occupancy.cells) sum += cell.vertices;
  EXPECT_EQ(sum, file.positions.size());
}

}  // namespace
}  // namespace colossus::pipeline::ingest
