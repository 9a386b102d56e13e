// What a scheme hands to assembly: its finished nodes, and what the container says of them.
#pragma once

#include <cstdint>
#include <vector>

#include "codec/coded_node.hpp"
#include "container/schema.hpp"
#include "scratch/spool.hpp"
#include "simplify/region.hpp"

namespace colossus::build {

// Sums over the nodes of a level; integers, so that they do not depend on any order.
struct NodeStatistics {
  // Of inner nodes: what there was of the children, what was aimed at, what was reached before quantisation.
  std::uint64_t initial_triangles = 0;
  std::uint64_t target_triangles = 0;
  std::uint64_t reached_triangles = 0;
  std::uint64_t initial_vertices = 0;
  std::uint64_t locked_vertices = 0;
  simplify::AngleCounts angles;  // of leaves too
};

// What assembly needs of a node. Rank 0 keeps it for all nodes, to the end.
struct StoredNode {
  container::NodeRow row;
  scratch::RecordRef chunk;
};

struct FinishedNode : StoredNode {
  NodeStatistics statistics;
  double displacement = 0.0;                             // by quantisation, world units
  codec::PerComponent<std::uint64_t> component_bytes{};  // of the stored bytes
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
  codec::PerComponent<std::uint64_t> component_bytes{};
  NodeStatistics sums;
};

// Nodes and levels are on rank 0, the rest on all ranks.
struct Hierarchy {
  std::vector<StoredNode> nodes;
  std::vector<LevelStatistics> levels;  // from the root on
  container::LatticeInfo lattice;       // on which decoded positions lie
  int position_bits = 0;
  std::vector<container::NamedText> options;     // of the scheme, besides those that all have
  std::vector<container::NamedReal> parameters;  // of the scheme

  void add(const FinishedNode& node);
  // What was not done for one node alone.
  void add(std::uint32_t level, const NodeStatistics& statistics);
  // Orders the nodes by level and centre.
  void sort();
};

}  // namespace colossus::build
