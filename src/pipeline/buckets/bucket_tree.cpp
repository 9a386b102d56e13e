#include "pipeline/buckets/bucket_tree.hpp"

#include <algorithm>
#include <array>

#include "core/error.hpp"

namespace colossus::pipeline::buckets {
namespace {

using geometry::Point;

constexpr int kRootTableLevels = 7;   // 2^21 cells, 8 MB
constexpr int kInnerTableLevels = 3;  // of which there may be many

CubeId ancestor(const CubeId& cube, int level) {
  const int up = cube.level - level;
  return {level, cube.x >> up, cube.y >> up, cube.z >> up};
}

}  // namespace

BucketTree::BucketTree(std::vector<CubeId> cubes) : cubes_(std::move(cubes)) {
  COLOSSUS_CHECK(!cubes_.empty() && cubes_.size() < kIsTable);
  add_table({0, 0, 0, 0}, 0, static_cast<std::uint32_t>(cubes_.size()), kRootTableLevels);
}

// For the cubes [begin, end), which tile `cube`. Returns its number.
std::uint32_t BucketTree::add_table(const CubeId& cube, std::uint32_t begin, std::uint32_t end,
                                    int most_finer) {
  int deepest = cube.level;
  for (std::uint32_t i = begin; i < end; ++i) deepest = std::max(deepest, cubes_[i].level);
  const auto number = static_cast<std::uint32_t>(tables_.size());
  const Table table{cube, std::min(deepest - cube.level, most_finer), cells_.size()};
  tables_.push_back(table);
  cells_.resize(cells_.size() + (std::size_t{1} << (3 * table.finer)));
  const int level = cube.level + table.finer;
  for (std::uint32_t i = begin; i < end;) {
    if (cubes_[i].level <= level) {
      fill(table, cubes_[i], i);
      ++i;
      continue;
    }
    const CubeId cell = ancestor(cubes_[i], level);
    const std::uint32_t first = i;
    while (i < end && cubes_[i].level > level && ancestor(cubes_[i], level) == cell) ++i;
    const std::uint32_t inner = add_table(cell, first, i, kInnerTableLevels);
    cells_[cell_index(table, cell.x, cell.y, cell.z)] = kIsTable | inner;
  }
  return number;
}

void BucketTree::fill(const Table& table, const CubeId& cube, std::uint32_t value) {
  const int finer = table.cube.level + table.finer - cube.level;
  for (std::int32_t z = cube.z << finer; z < (cube.z + 1) << finer; ++z)
    for (std::int32_t y = cube.y << finer; y < (cube.y + 1) << finer; ++y)
      for (std::int32_t x = cube.x << finer; x < (cube.x + 1) << finer; ++x)
        cells_[cell_index(table, x, y, z)] = value;
}

// Of a cell at the table's finest level, counted in the root cube.
std::size_t BucketTree::cell_index(const Table& table, std::int32_t x, std::int32_t y, std::int32_t z) const {
  const auto local = [&](std::int32_t i, std::int32_t of_cube) {
    return static_cast<std::size_t>(i - (of_cube << table.finer));
  };
  return table.first + ((local(z, table.cube.z) << table.finer | local(y, table.cube.y)) << table.finer |
                        local(x, table.cube.x));
}

std::uint32_t BucketTree::at(const Point& p) const {
  for (const Table* table = &tables_[0];;) {
    const int shift = geometry::kRootBits - table->cube.level - table->finer;
    const std::uint32_t cell = cells_[cell_index(*table, p.x >> shift, p.y >> shift, p.z >> shift)];
    if ((cell & kIsTable) == 0) return cell;
    table = &tables_[cell & ~kIsTable];
  }
}

void BucketTree::find(const Point& low, const Point& high, std::vector<std::uint32_t>& met) const {
  met.clear();
  find_in(tables_[0], low, high, met);
  if (met.size() == 1) return;
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
}

void BucketTree::find_in(const Table& table, const Point& low, const Point& high,
                         std::vector<std::uint32_t>& met) const {
  const int shift = geometry::kRootBits - table.cube.level - table.finer;
  const std::array<std::int32_t, 3> corner{table.cube.x, table.cube.y, table.cube.z};
  std::array<std::int32_t, 3> from;
  std::array<std::int32_t, 3> to;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    from[k] = std::max(low[axis] >> shift, corner[k] << table.finer);
    to[k] = std::min(high[axis] >> shift, ((corner[k] + 1) << table.finer) - 1);
  }
  for (std::int32_t z = from[2]; z <= to[2]; ++z)
    for (std::int32_t y = from[1]; y <= to[1]; ++y)
      for (std::int32_t x = from[0]; x <= to[0]; ++x) {
        const std::uint32_t cell = cells_[cell_index(table, x, y, z)];
        if ((cell & kIsTable) != 0)
          find_in(tables_[cell & ~kIsTable], low, high, met);
        else
          met.push_back(cell);
      }
}

}  // namespace colossus::pipeline::buckets
