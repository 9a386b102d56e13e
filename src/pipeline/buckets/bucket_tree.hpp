// A partition of the root cube into the cubes of an octree, and which of them a box meets.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/point.hpp"

namespace colossus::pipeline::buckets {

// A cube of side 2^(30 - depth) at index (x, y, z).
struct Cube {
  std::int32_t depth = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  bool contains(const geometry::Point& p) const {
    const int shift = geometry::kRootBits - depth;
    return p.x >> shift == x && p.y >> shift == y && p.z >> shift == z;
  }
  Cube child(int octant) const {
    return {depth + 1, 2 * x + (octant & 1), 2 * y + (octant >> 1 & 1), 2 * z + (octant >> 2)};
  }
  friend bool operator==(const Cube&, const Cube&) = default;
};

// Looks up in tables of cells: one of up to 2^21 cells for the root cube, and where cubes are deeper, one
// below a cell.
class BucketTree {
 public:
  // The cubes tile the root cube, in the order in which a descent into octants 0 to 7 meets them. They are
  // numbered in that order.
  explicit BucketTree(std::vector<Cube> cubes);

  std::span<const Cube> cubes() const { return cubes_; }
  std::uint32_t at(const geometry::Point& p) const;
  // Replaces `met` by the cubes that the closed box from `low` to `high` meets, ascending. The box lies in
  // the root cube.
  void find(const geometry::Point& low, const geometry::Point& high, std::vector<std::uint32_t>& met) const;

 private:
  struct Table {
    Cube cube;
    int finer = 0;          // levels
    std::size_t first = 0;  // of its cells
  };
  static constexpr std::uint32_t kIsTable = std::uint32_t{1} << 31;

  std::uint32_t add_table(const Cube& cube, std::uint32_t begin, std::uint32_t end, int most_finer);
  void fill(const Table& table, const Cube& cube, std::uint32_t value);
  std::size_t cell_index(const Table& table, std::int32_t x, std::int32_t y, std::int32_t z) const;
  void find_in(const Table& table, const geometry::Point& low, const geometry::Point& high,
               std::vector<std::uint32_t>& met) const;

  std::vector<Cube> cubes_;
  std::vector<Table> tables_;         // the root's first
  std::vector<std::uint32_t> cells_;  // number of a cube, or of a table
};

}  // namespace colossus::pipeline::buckets
