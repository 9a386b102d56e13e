// A partition of the root cube into the cubes of an octree, and which of them a box meets.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hierarchy/octree.hpp"

namespace colossus::pipeline::buckets {

using hierarchy::CubeId;

// Looks up in tables of cells: one of up to 2^21 cells for the root cube, and where cubes are deeper, one
// below a cell.
class BucketTree {
 public:
  // The cubes tile the root cube, in the order in which a descent into octants 0 to 7 meets them. They are
  // numbered in that order.
  explicit BucketTree(std::vector<CubeId> cubes);

  std::span<const CubeId> cubes() const { return cubes_; }
  std::uint32_t at(const geometry::Point& p) const;
  // Replaces `met` by the cubes that the closed box from `low` to `high` meets, ascending. The box lies in
  // the root cube.
  void find(const geometry::Point& low, const geometry::Point& high, std::vector<std::uint32_t>& met) const;

 private:
  struct Table {
    CubeId cube;
    int finer = 0;          // levels
    std::size_t first = 0;  // of its cells
  };
  static constexpr std::uint32_t kIsTable = std::uint32_t{1} << 31;

  std::uint32_t add_table(const CubeId& cube, std::uint32_t begin, std::uint32_t end, int most_finer);
  void fill(const Table& table, const CubeId& cube, std::uint32_t value);
  std::size_t cell_index(const Table& table, std::int32_t x, std::int32_t y, std::int32_t z) const;
  void find_in(const Table& table, const geometry::Point& low, const geometry::Point& high,
               std::vector<std::uint32_t>& met) const;

  std::vector<CubeId> cubes_;
  std::vector<Table> tables_;         // the root's first
  std::vector<std::uint32_t> cells_;  // number of a cube, or of a table
};

}  // namespace colossus::pipeline::buckets
