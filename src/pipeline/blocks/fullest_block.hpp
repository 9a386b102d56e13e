// How much the largest task will hold, before any block is known.
#pragma once

#include "pipeline/ingest/occupancy.hpp"

namespace colossus::pipeline::blocks {

// Most vertices in a block of `size` cubes of a level, shifted by half as in hierarchy/octree.hpp; beyond
// what the occupancy resolves as many as a surface has.
double most_in_block(const ingest::Occupancy& occupancy, int level, int size);

}  // namespace colossus::pipeline::blocks
