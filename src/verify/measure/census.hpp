// Border and non-manifold edges of the cuts of every level, in one pass over the
// nodes; and the inconsistently oriented edges within nodes.
//
// An edge with ends on no common face of its tetrahedron is used in this one only, so it is counted there;
// only edges within faces are gathered, per level, with those of the leaves above. Edges are told apart by
// 128-bit hashes of their exact ends. An edge is a border edge when one triangle uses it, non-manifold when
// more than two do, inconsistent when exactly two triangles of one part do, both in the same direction.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/coded/weights.hpp"
#include "core/hash.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify::measure {

struct EdgeUses {
  core::Hash128 edge;
  std::uint32_t uses = 0;
};

struct EdgeCounts {
  std::uint64_t triangles = 0;
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
  EdgeCounts& operator+=(const EdgeCounts& other);
};

// What one tetrahedron, or one cube, contributes.
struct PartCensus {
  EdgeCounts inside;
  std::vector<EdgeUses> shared;
  std::uint64_t inconsistent_edges = 0;  // inside and shared
  bool has_shared_places = false;        // quantisation has laid vertices onto each other
};

// Of welded positions, and triangles without two equal ones. An edge may be used elsewhere when its ends have
// a bit of `shared_bits` in common; anything else is counted here.
PartCensus take_census(std::span<const codec::coded::ScaledPosition> positions,
                       std::span<const std::uint8_t> shared_bits, std::span<const mesh::Triangle> triangles);

struct LevelCounts {
  EdgeCounts cut;
  // A damaged node lies in the cut: edges that it might use are not counted.
  bool is_partial = false;
  bool has_shared_places = false;  // somewhere in the cut
};

// Into the report of the level.
void report_cut(const LevelCounts& counts, LevelReport& report);

// Sums up the uniform cuts, coarsest first. Memory: the edges within faces of one level and of the leaves
// above it.
class LevelCensus {
 public:
  void add(PartCensus&& census, bool is_leaf);
  // A node of this level whose parts are not known.
  void add_damaged(bool is_leaf) { (is_leaf ? leaves_ : split_).is_damaged = true; }
  // The counts of the cut at this level; the next additions belong to the next level.
  LevelCounts finish_level();
  // Of the leaves of this level and above, without the edges that other parts may use.
  const EdgeCounts& inside_leaves() const { return leaves_.inside; }

 private:
  struct Part {
    EdgeCounts inside;
    std::vector<EdgeUses> shared;
    bool is_damaged = false;
    bool has_shared_places = false;
  };
  Part leaves_;  // of this level and above
  Part split_;   // of this level
};

}  // namespace colossus::verify::measure
