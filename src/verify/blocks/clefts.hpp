// For verify() and tests/bench/clefts: whether triangles are denser along the borders of blocks than between
// them.
//
// Level l was made of the cubes of level l + 1, block by block, with the borders of these blocks locked; the
// borders of the blocks of levels l + 2 and finer were locked earlier, and should have been simplified since.
#pragma once

#include <array>
#include <cstdint>

#include "codec/coded/lattice_node.hpp"
#include "reader/blocks/statue.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify::blocks {

// Of one cube, or of many. A statue is nowhere like elsewhere, and borders are few on coarse levels: so what
// is near them is compared with the interior of the same cube. Cubes without much of an interior do not
// count.
struct CleftCounts {
  enum Zone : std::size_t { kLocked, kEarlier };
  std::array<std::uint64_t, 2> triangles{};
  std::array<double, 2> expected{};  // if the cube's interior had gone on
  void add(const CleftCounts& other);
  measure::CleftDensities densities() const;
};

// Sorts the triangles of a cube of this level by their barycentres: kLocked when within `width` (lattice
// units; one edge length) of a border locked for this level, else kEarlier when within it of an earlier one.
// Borders less than eight widths apart would leave no interior, so the finest ones are left out. No container
// says that its blocks are not shifted.
CleftCounts count_clefts(const reader::blocks::Statue& statue, int level, const codec::coded::CodedNode& node,
                         double width, bool has_shifted_blocks = true);

struct EdgeLengths {
  double sum = 0.0;
  std::uint64_t count = 0;
  double mean() const { return count == 0 ? 0.0 : sum / static_cast<double>(count); }
};
// Of the triangles' edges, each as often as it is used; lattice units.
EdgeLengths edge_lengths(const codec::coded::CodedNode& node);

}  // namespace colossus::verify::blocks
