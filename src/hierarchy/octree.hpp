// The octree as pure index arithmetic: its cubes, which buckets are, too, and the blocks of the scheme blocks
// (Li 2024, sections 3.2.3 to 3.2.6).
//
// At level l the root cube [0, 2^30]^3 is divided into 2^l cubes along each axis. A block is n x n x n cubes,
// shifted by n/2: block b of a level holds the cubes from n * b - n/2 to n * b + n/2 - 1 along each axis.
// With n a multiple of 4 the borders of the blocks of one level are interior at the next, and the eight cubes
// of one parent are in one block. Cubes, blocks and points are in units of the root cube's lattice.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#include "geometry/point.hpp"

namespace colossus::hierarchy {

// The scheme whose nodes are cubes, and whose tasks are blocks of these, in containers and options.
inline constexpr const char* kBlocks = "blocks";

// The container's lattice still has to tell a cube's centre from its corners, and positions from each other.
inline constexpr int kMaxCubeLevel = 20;
inline constexpr int kLeastBlockSize = 4;
inline constexpr int kGreatestBlockSize = 64;

// A cube of the octree. Levels up to geometry::kRootBits are possible; containers go to kMaxCubeLevel.
struct CubeId {
  std::int32_t level = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  friend auto operator<=>(const CubeId&, const CubeId&) = default;

  CubeId parent() const { return {level - 1, x >> 1, y >> 1, z >> 1}; }
  // The cube that holds it at this level, of at most its own.
  CubeId ancestor(int at) const {
    const int up = level - at;
    return {at, x >> up, y >> up, z >> up};
  }
  // Bit i of the octant: the upper half of axis i.
  CubeId child(int octant) const {
    return {level + 1, 2 * x + (octant & 1), 2 * y + (octant >> 1 & 1), 2 * z + (octant >> 2)};
  }
  bool is_inside_root() const;  // and no deeper than kMaxCubeLevel
  // Of a point of the lattice whose root cube has sides of 2^root_bits; level <= root_bits.
  bool contains(const geometry::Point& p, int root_bits) const {
    const int shift = root_bits - level;
    return p.x >> shift == x && p.y >> shift == y && p.z >> shift == z;
  }
  // Lowest corner and side on a lattice whose root cube has sides of 2^root_bits; level <= root_bits.
  geometry::Point corner(int root_bits) const;
  std::int64_t side(int root_bits) const { return std::int64_t{1} << (root_bits - level); }
  // level < root_bits.
  geometry::Point center(int root_bits) const;
};

// The cube of this level with this centre on the lattice of 2^root_bits; when there is none, one that is not
// inside the root.
CubeId cube_at(const geometry::Point& center, int level, int root_bits);

// The cube that holds the barycentre of three points of the lattice of 2^root_bits: exact. A barycentre on a
// border belongs to the upper cube.
CubeId cube_of_barycenter(const geometry::Point& p, const geometry::Point& q, const geometry::Point& r,
                          int level, int root_bits);

struct BlockId {
  std::int32_t level = 0;  // of its cubes
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  friend auto operator<=>(const BlockId&, const BlockId&) = default;
};

// The block of size n that holds a cube. Level 0 has the one block (0, 0, 0).
BlockId block_of(const CubeId& cube, int n);

// The same of blocks that are not shifted: block b holds the cubes from n * b to n * b + n - 1, and the
// borders of every level are also borders of all finer ones. For comparison only.
BlockId unshifted_block_of(const CubeId& cube, int n);

// Whether the cube is one of the block's, or touches one of them from outside.
bool touches(const BlockId& block, int n, const CubeId& cube);

// The maximum norm.
std::int64_t max_distance(const geometry::Point& a, const geometry::Point& b);

struct CubeIdHash {
  std::size_t operator()(const CubeId& cube) const;
};

}  // namespace colossus::hierarchy
