// A cube's mesh to bytes and back: packed planes, made small by the container's zstd frame.
// schemas/container.md describes the bytes.
#pragma once

#include <span>

#include "codec/cube_mesh.hpp"
#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::codec {

// Positions are stored against the least of each coordinate, with as many bits as the widest axis needs; no
// coordinate is below -2^30. Vertices must be in order of first use by the triangles, unused ones last.
core::Bytes encode(const CubeMesh& cube);

// Total on any input: a Defect, never undefined behaviour, and no more memory than a small multiple of the
// input. Indices of triangles are in range; those of parents are checked by who has the parent.
// Encoding what comes back gives the same bytes: other encodings of the same mesh are refused.
core::Result<CubeMesh> decode_cube(std::span<const std::byte> bytes);

}  // namespace colossus::codec
