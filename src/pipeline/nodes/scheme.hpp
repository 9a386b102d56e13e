// A scheme is a shape that the builder serves: it says which leaf a triangle belongs to and whether it is
// cut, which nodes make up a level, which vertices may move or vanish while a node is simplified, and how a
// node is stored. Everything else is written once.
#pragma once

#include <span>
#include <vector>

#include "pipeline/facts/catalog.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/ingest/join.hpp"
#include "pipeline/ingest/occupancy.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::nodes {

// What the nodes of a scheme will need; its constants were measured, see src/README.md.
struct NodeNeeds {
  double task_bytes = 0.0;        // of memory, for the largest task
  double stored_triangles = 0.0;  // of all nodes, per triangle of the input
  double node_triangles = 0.0;    // of a node of the finest level: borders are stored by several nodes
  double more_bytes = 0.0;        // per stored triangle, beside what the codec says of a mesh
  double scratch_bytes = 0.0;     // of the levels while they are made, per triangle of the input
  double kept_output = 0.0;       // the share of the output that lies in scratch meanwhile
};

struct Scheme {
  const char* name;
  const char* description;                       // one line, for --help; likewise:
  const char* leaf_triangles_of;                 // "per leaf": what --leaf-triangles are triangles of
  const char* position_bits_of;                  // "per weight": what --position-bits are bits of
  std::span<const facts::SchemeOption> options;  // beside those that all schemes have
  // Throws Error(kUsage) for options that make no sense for it; null: all do. Not collective.
  void (*check)(const facts::BuildOptions& options);
  // From the counts of the survey. Not collective.
  NodeNeeds (*estimate)(const facts::BuildOptions& options, const facts::Catalog& catalog,
                        const ingest::Occupancy& occupancy);
  // Collective. From groups of triangles with vertices on the lattice to finished nodes, all in scratch.
  // buckets::make_buckets() and LevelDriver do what all schemes owe: memory is asked for before it is used,
  // phases are released that nobody reads any more, --tolerance and the surface are kept. The scheme itself
  // adds to the catalogue's counts what it did to edges and triangles, on all ranks; where its own rounding
  // is coarser than the lattice's, it calls ingest::refuse_far_corner().
  facts::FinishedNodes (*build)(const run::Workspace& workspace, facts::Catalog& catalog,
                                std::vector<ingest::TriangleGroup>&& groups);
};

}  // namespace colossus::pipeline::nodes
