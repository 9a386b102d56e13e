// A conforming cut of diamonds as one indexed mesh, and as a PLY file.
#pragma once

#include "reader/cut.hpp"
#include "reader/cut_mesh.hpp"

namespace colossus::reader {

// Vertices are welded by position across tetrahedra (equal exact positions are bit-equal), in order of first
// occurrence in the cut (rows in order, places ascending); the attributes are those of the first. Triangles
// with two equal positions are dropped, nothing else. Memory: proportional to the result. Throws like
// Statue::load() and CutMesh::add_position().
CutMesh assemble(const Statue& statue, const Cut& cut);

// Assembles and writes. Throws like both.
ExtractResult extract(const Statue& statue, const Cut& cut, const core::OutputTarget& target);

}  // namespace colossus::reader
