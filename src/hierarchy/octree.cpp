#include "hierarchy/octree.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "core/error.hpp"

namespace colossus::hierarchy {
namespace {

// Rounded towards minus infinity; b is positive.
std::int64_t floor_divide(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

BlockId block_of(const CubeId& cube, int n, int shift) {
  COLOSSUS_CHECK(n >= kLeastBlockSize && n <= kGreatestBlockSize && n % 4 == 0, "blocks of {} cubes", n);
  const auto along = [&](std::int32_t index) {
    return static_cast<std::int32_t>(floor_divide(std::int64_t{index} + shift, n));
  };
  return {cube.level, along(cube.x), along(cube.y), along(cube.z)};
}

bool touches_along_axis(std::int32_t block_index, int n, std::int32_t cube_index) {
  const std::int64_t lowest = std::int64_t{block_index} * n - n / 2;
  return cube_index >= lowest - 1 && cube_index <= lowest + n;
}

}  // namespace

bool CubeId::is_inside_root() const {
  if (level < 0 || level > kMaxCubeLevel) return false;
  const std::int32_t count = std::int32_t{1} << level;
  return x >= 0 && y >= 0 && z >= 0 && x < count && y < count && z < count;
}

geometry::Point CubeId::corner(int root_bits) const {
  const auto along = [&](std::int32_t index) { return static_cast<std::int32_t>(index * side(root_bits)); };
  return {along(x), along(y), along(z)};
}

geometry::Point CubeId::center(int root_bits) const {
  const auto half = static_cast<std::int32_t>(side(root_bits) / 2);
  const geometry::Point low = corner(root_bits);
  return {low.x + half, low.y + half, low.z + half};
}

CubeId cube_at(const geometry::Point& center, int level, int root_bits) {
  const CubeId none{level, -1, -1, -1};
  if (level < 0 || level > kMaxCubeLevel || level >= root_bits) return none;
  const int shift = root_bits - level;
  const CubeId cube{level, center.x >> shift, center.y >> shift, center.z >> shift};
  return cube.is_inside_root() && cube.center(root_bits) == center ? cube : none;
}

CubeId cube_of_barycenter(const geometry::Point& p, const geometry::Point& q, const geometry::Point& r,
                          int level, int root_bits) {
  COLOSSUS_CHECK(level >= 0 && level <= root_bits, "level {} on a lattice of {} bits", level, root_bits);
  // Three coordinates add up to at most 3 * 2^31 in size, and three sides to 3 * 2^30.
  const std::int64_t three_sides = 3 * (std::int64_t{1} << (root_bits - level));
  std::array<std::int32_t, 3> index{};
  for (int axis = 0; axis < 3; ++axis)
    index[static_cast<std::size_t>(axis)] =
        static_cast<std::int32_t>(floor_divide(std::int64_t{p[axis]} + q[axis] + r[axis], three_sides));
  return {level, index[0], index[1], index[2]};
}

BlockId block_of(const CubeId& cube, int n) { return block_of(cube, n, n / 2); }

BlockId unshifted_block_of(const CubeId& cube, int n) { return block_of(cube, n, 0); }

bool touches(const BlockId& block, int n, const CubeId& cube) {
  return block.level == cube.level && touches_along_axis(block.x, n, cube.x) &&
         touches_along_axis(block.y, n, cube.y) && touches_along_axis(block.z, n, cube.z);
}

std::int64_t max_distance(const geometry::Point& a, const geometry::Point& b) {
  std::int64_t distance = 0;
  for (int axis = 0; axis < 3; ++axis)
    distance = std::max(distance, std::abs(std::int64_t{a[axis]} - b[axis]));
  return distance;
}

std::size_t CubeIdHash::operator()(const CubeId& cube) const {
  const auto word = [](std::int32_t high, std::int32_t low) {
    return std::uint64_t{static_cast<std::uint32_t>(high)} << 32 | static_cast<std::uint32_t>(low);
  };
  return core::mix64(word(cube.x, cube.y) ^ core::mix64(word(cube.level, cube.z) + 0x9e3779b97f4a7c15ULL));
}

}  // namespace colossus::hierarchy
