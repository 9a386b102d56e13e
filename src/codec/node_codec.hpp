// A node of tetrahedra to bytes and back, by any codec. schemas/container.md describes the bytes.
#pragma once

#include <span>

#include "codec/coded/node_mesh.hpp"
#include "codec/payload.hpp"

namespace colossus::codec {

// The order in which the codec stores this mesh: of its triangles, and of its vertices by first use.
void put_in_order(coded::QuantizedTetrahedron& part, const Codec& codec);

// Tetrahedra must be by ascending place, each as put_in_order() leaves it.
Payload encode(const coded::NodeMesh& node, const Codec& codec);

// Total on any input: a Defect, never undefined behaviour, and no more memory than `most` allows. What comes
// back is valid: places ascend, weights sum to 2^bits, indices are in range, triangles use all vertices.
core::Result<coded::NodeMesh> decode(std::span<const std::byte> bytes, const NodeCounts& most);

}  // namespace colossus::codec
