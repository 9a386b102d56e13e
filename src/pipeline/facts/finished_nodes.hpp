// What a scheme hands to assembly: its finished nodes, and what the container says of them.
#pragma once

#include <cstdint>
#include <vector>

#include "codec/coded/coded_node.hpp"
#include "container/schema.hpp"
#include "pipeline/facts/options.hpp"
#include "scratch/spool.hpp"
#include "simplify/region.hpp"

namespace colossus::pipeline::facts {

// Sums over the nodes of a level; integers, so that they do not depend on any order. Each member, and each
// of LevelStatistics, is a line in level_table.hpp.
struct NodeStatistics {
  // Of inner nodes: what there was of the children, what was aimed at, what was reached before quantisation.
  std::uint64_t initial_triangles = 0;
  std::uint64_t target_triangles = 0;
  std::uint64_t reached_triangles = 0;
  std::uint64_t initial_vertices = 0;
  std::uint64_t locked_vertices = 0;
  simplify::AngleCounts angles;  // of leaves too
  // Edges that two triangles of one tetrahedron, or cube, use in the same direction; of leaves too.
  std::uint64_t inconsistent_edges = 0;
  // Of the finest level alone; of diamonds without edges within faces, which both sides have.
  std::uint64_t finest_border_edges = 0;
  std::uint64_t finest_nonmanifold_edges = 0;

  NodeStatistics& operator+=(const NodeStatistics& other);
};

// What assembly needs of a node. Rank 0 keeps it for all nodes, to the end.
struct StoredNode {
  container::NodeRow row;
  scratch::RecordRef chunk;
  double area = 0.0;  // of a leaf's surface, square units of the container's lattice
};

struct FinishedNode : StoredNode {
  NodeStatistics statistics;
  double displacement = 0.0;                                    // by quantisation, world units
  codec::coded::PerComponent<std::uint64_t> component_bytes{};  // of the stored bytes
};

struct LevelStatistics {
  std::uint64_t nodes = 0;
  std::uint64_t leaves = 0;
  std::uint64_t leaves_above_limit = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t payload_bytes = 0;
  std::uint64_t stored_bytes = 0;
  double error = 0.0;         // greatest of the level's nodes, world units
  double displacement = 0.0;  // greatest by quantisation
  codec::coded::PerComponent<std::uint64_t> component_bytes{};
  NodeStatistics sums;
};

// Nodes and levels are on rank 0, the rest on all ranks.
struct FinishedNodes {
  std::vector<StoredNode> nodes;
  std::vector<LevelStatistics> levels;  // from the root on
  container::LatticeInfo lattice;       // on which decoded positions lie
  int position_bits = 0;
  std::vector<container::NamedText> options;          // of the scheme, besides those that all have
  std::vector<container::NamedText> option_meanings;  // of these, see Metadata
  std::vector<container::NamedReal> parameters;       // of the scheme

  void add(const FinishedNode& node);
  // What was not done for one node alone.
  void add(std::uint32_t level, const NodeStatistics& statistics);
  // Orders the nodes by level and centre.
  void sort();
  // Of the leaves of sorted nodes, whose sum does not depend on the order in which they were finished.
  double finest_area() const;
  std::uint64_t finest_triangles() const;
};

// Throws Error(kUsage) when the greatest error of the finest level is above options.tolerance. Not
// collective; before the first level is simplified.
void require_tolerance(const BuildOptions& options, double greatest_error);

// When a level has more than a tenth more triangles than were aimed at. Not collective.
void warn_of_missed_target(const FinishedNodes& finished, std::uint32_t level);

}  // namespace colossus::pipeline::facts
