// A scheme is a shape that the builder serves: it says which leaf a triangle belongs to and whether it is
// cut, which nodes make up a level, which vertices may move or vanish while a node is simplified, and how a
// node is stored. Everything else is written once.
#pragma once

#include <span>
#include <string_view>

#include "build/catalog.hpp"
#include "build/hierarchy.hpp"
#include "build/join.hpp"
#include "build/workspace.hpp"

namespace colossus::build {

struct Scheme {
  const char* name;
  // Throws Error(kUsage) for options that make no sense for it. Not collective.
  void (*check)(const BuildOptions& options);
  // Collective. From groups of triangles with vertices on the lattice to finished nodes, all in scratch;
  // completes the catalogue's counts and area.
  Hierarchy (*build)(const Workspace& workspace, Catalog& catalog, std::vector<TriangleGroup>&& groups);
};

// All of them, the default one first.
std::span<const Scheme> schemes();

// Throws Error(kUsage) that lists the schemes when there is none of this name.
const Scheme& scheme_named(std::string_view name);

}  // namespace colossus::build
