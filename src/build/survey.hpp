// Phase 1: reads every input once, checks it, and copies its blocks to scratch.
#pragma once

#include "build/catalog.hpp"
#include "build/workspace.hpp"

namespace colossus::build {

// The catalogue of raw blocks with bounds and counts; the same on all ranks. Throws on bad data and when
// there is no triangle at all. Collective.
Catalog survey(const Workspace& workspace);

// Phase 2: puts the vertices onto the lattice that fits the bounds, computes missing normals from the whole
// mesh (area weighted, summed in 128-bit integers by position, so that they depend on no order), and averages
// the attributes of vertices at one position. Replaces the catalogue's vertex blocks; fills lattice and
// counts. Collective.
void place_on_lattice(const Workspace& workspace, Catalog& catalog);

// Rounds all coordinates to multiples of `spacing`, a power of two, and merges the attributes of vertices
// that this puts at one position. Replaces the catalogue's vertex blocks; the counts stay those of the input.
// Collective.
void round_positions(const Workspace& workspace, Catalog& catalog, std::int32_t spacing);

}  // namespace colossus::build
