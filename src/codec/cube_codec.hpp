// A cube's mesh to bytes and back, by any codec. schemas/container.md describes the bytes.
#pragma once

#include <span>

#include "codec/coded/cube_mesh.hpp"
#include "codec/payload.hpp"

namespace colossus::codec {

// Positions are stored against the least of each coordinate, with as many bits as the widest axis needs; no
// coordinate is below -2^30. Triangles must be in the codec's order, vertices in that of their first use,
// unused ones last: parents of other cubes' vertices are numbers in this order, so it is fixed before.
Payload encode(const coded::CubeMesh& cube, const Codec& codec);

// Total on any input: a Defect, never undefined behaviour, and no more memory than `most` allows. Indices of
// triangles are in range; those of parents are checked by who has the parent. Vertices are in order of first
// use, unused ones last.
core::Result<coded::CubeMesh> decode_cube(std::span<const std::byte> bytes, const NodeCounts& most);

}  // namespace colossus::codec
