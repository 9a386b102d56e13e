// A scheme is a shape that the builder serves: it says which leaf a triangle belongs to and whether it is
// cut, which nodes make up a level, which vertices may move or vanish while a node is simplified, and how a
// node is stored. Everything else is written once.
#pragma once

#include <vector>

#include "pipeline/facts/catalog.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/ingest/join.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::nodes {

struct Scheme {
  const char* name;
  // Throws Error(kUsage) for options that make no sense for it. Not collective.
  void (*check)(const facts::BuildOptions& options);
  // Collective. From groups of triangles with vertices on the lattice to finished nodes, all in scratch;
  // completes the catalogue's counts and area.
  facts::Hierarchy (*build)(const run::Workspace& workspace, facts::Catalog& catalog,
                            std::vector<ingest::TriangleGroup>&& groups);
};

}  // namespace colossus::pipeline::nodes
