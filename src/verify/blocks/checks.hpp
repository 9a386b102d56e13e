// Private to this folder: what verify() checks of one cube, and of its children against it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "reader/blocks/statue.hpp"
#include "verify/blocks/clefts.hpp"
#include "verify/measure/census.hpp"
#include "verify/measure/finest.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify::blocks {

// A vertex that other cubes of its level may have as well.
struct SharedVertex {
  geometry::Point position;
  geometry::Point parent;
  std::array<std::uint8_t, 2> normal{};
  mesh::Color color{};
  reader::access::RowIndex row = reader::access::kNoRow;
};

// How far, in lattice units and rounded up, a vertex of a cube of the level can lie outside the cube, by the
// rows' bounds. A vertex deeper than that within its cube is in no other one.
std::int64_t greatest_overhang(const reader::blocks::Statue& statue, std::uint32_t level);

// What check_cube() must know about the levels.
struct LevelFacts {
  std::int64_t overhang = 0;
  std::int64_t child_overhang = 0;
  double edge_length = 0.0;  // mean, lattice units; 0: the cube's own
};

// A cube's mesh, and where its vertices lie on the lattice.
struct CheckedMesh {
  CheckedMesh() : CheckedMesh(codec::coded::lattice_node()) {}
  explicit CheckedMesh(codec::coded::CodedNode decoded)
      : node(std::move(decoded)), positions(codec::coded::lattice_positions(node)) {}
  const codec::coded::CodedPart& part() const { return node.parts[0]; }
  codec::coded::CodedNode node;
  std::vector<geometry::Point> positions;
};

struct CubeReport {
  std::vector<measure::Finding> findings;
  measure::PartCensus census;
  CleftCounts clefts;
  CheckedMesh mesh;  // empty when it is damaged
  bool is_damaged = false;
  measure::FinestSurface finest;  // of a cube of the deepest level
  // Of the children:
  std::vector<SharedVertex> shared;
  EdgeLengths edge_lengths;
  std::uint64_t parents = 0;
  std::uint64_t mapped_triangles = 0;
};

// The row against other rows, its mesh against the row and the conditions, and its children's parent maps
// against it. Throws Error(kIo) when the device fails.
CubeReport check_cube(const reader::blocks::Statue& statue, reader::access::RowIndex row,
                      const LevelFacts& facts);

// Cubes that share a vertex of one level must agree about it. Sorts.
std::vector<measure::Finding> check_shared(const reader::blocks::Statue& statue,
                                           std::vector<SharedVertex>& vertices);

}  // namespace colossus::verify::blocks
