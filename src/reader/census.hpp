// Private to this folder: border and non-manifold edges of the cuts of every level, in one pass over the
// nodes.
//
// An edge with ends on no common face of its tetrahedron is used in this one only, so it is counted there;
// only edges and triangles within faces are gathered, per level, with those of the leaves above. Edges are
// told apart by 128-bit hashes of their exact ends. An edge is a border edge when one triangle uses it,
// non-manifold when more than two do.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/node_mesh.hpp"
#include "core/hash.hpp"

namespace colossus::reader {

struct EdgeUses {
  core::Hash128 edge;
  std::uint32_t uses = 0;
};

// A triangle flat in a face: one on the other side may cancel it.
struct FlatTriangle {
  core::Hash128 corners;
  std::int32_t direction = 0;  // 1 or -1
  std::array<core::Hash128, 3> edges;
};

struct EdgeCounts {
  std::uint64_t triangles = 0;
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
};

// What one tetrahedron, or one cube, contributes.
struct PartCensus {
  EdgeCounts inside;
  std::vector<EdgeUses> shared;
  std::vector<FlatTriangle> flat;
};

// Of welded positions, and triangles without two equal ones or opposite pairs. An edge may be used elsewhere
// when its ends have a bit of `shared_bits` in common, a triangle when all its corners have; anything else is
// counted here.
PartCensus take_census(std::span<const codec::ScaledPosition> positions,
                       std::span<const std::uint8_t> shared_bits, std::span<const mesh::Triangle> triangles);

// Sums up the uniform cuts, coarsest first. Memory: the edges within faces of one level and of the leaves
// above it.
class LevelCensus {
 public:
  void add(PartCensus&& census, bool is_leaf);
  // The counts of the cut at this level; the next additions belong to the next level.
  EdgeCounts finish_level();

 private:
  struct Part {
    EdgeCounts inside;
    std::vector<EdgeUses> shared;
    std::vector<FlatTriangle> flat;
    void append(PartCensus&& census);
  };
  Part leaves_;  // of this level and above
  Part split_;   // of this level
};

}  // namespace colossus::reader
