// A conforming cut of diamonds as one indexed mesh.
#pragma once

#include "reader/access/cut_mesh.hpp"
#include "reader/diamonds/cut.hpp"

namespace colossus::reader::diamonds {

// Vertices are welded by position across tetrahedra (equal exact positions are bit-equal), in order of first
// occurrence in the cut (rows in order, places ascending); the attributes are those of the first. Triangles
// with two equal positions are dropped, nothing else. Memory: proportional to the result. Throws like
// Statue::load() and CutMesh::add_position().
access::CutMesh assemble(const Statue& statue, const Cut& cut);

}  // namespace colossus::reader::diamonds
