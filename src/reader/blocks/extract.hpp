// A cut of cubes as one indexed mesh.
#pragma once

#include "reader/access/cut_mesh.hpp"
#include "reader/blocks/cut.hpp"

namespace colossus::reader::blocks {

// Vertices are morphed as the cut says, each on the straight way to its parent, attributes likewise; a vertex
// at an end of its way is bit-equal to it. They are then welded like those of diamonds, in order of first
// occurrence in the cut (rows in order). Memory: proportional to the result. Throws like Statue::load()
// and CutMesh::add_position(), and Error(kBadData) when a vertex that is to be morphed has no parent.
access::CutMesh assemble(const Statue& statue, const Cut& cut);

}  // namespace colossus::reader::blocks
