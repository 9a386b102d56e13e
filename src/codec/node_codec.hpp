// A node's mesh to bytes and back. Version 1: packed planes, made small by the container's zstd frame.
// schemas/container.md describes the bytes.
#pragma once

#include <span>

#include "codec/node_mesh.hpp"
#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::codec {

// Vertices must be in order of first use by the triangles, tetrahedra by ascending place.
core::Bytes encode(const NodeMesh& node);

// Total on any input: a Defect, never undefined behaviour, and no more memory than a small multiple of the
// input. What comes back is valid: places ascend, weights sum to 2^bits, indices are in range.
core::Result<NodeMesh> decode(std::span<const std::byte> bytes);

}  // namespace colossus::codec
