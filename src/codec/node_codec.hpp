// A node's mesh to bytes and back, by any codec, and whether it is one that a reader may trust.
// schemas/container.md describes the bytes.
#pragma once

#include <span>

#include "codec/payload.hpp"

namespace colossus::codec {

// The order in which the codec stores this mesh: of its triangles, and of its vertices by first use.
void put_in_order(coded::CodedPart& part, const Codec& codec);

// Parts must be by ascending place, each as put_in_order() leaves it. On the lattice offset and bits must be
// what set_lattice_positions() makes of the positions, no coordinate below -2^30; numbers of vertices are
// those that the parents of other nodes' vertices are in, so their order is fixed before.
Payload encode(const coded::CodedNode& node, const Codec& codec);

// Total on any input: a Defect, never undefined behaviour, and no more memory than `most` allows. What comes
// back could have been encoded: places ascend, indices of triangles are in range, and vertices in order of
// first use.

// Weights sum to 2^bits, triangles use all vertices, and none has a parent.
core::Result<coded::CodedNode> decode_with_weights(std::span<const std::byte> bytes, const NodeCounts& most);

// Unused vertices come last. Indices of parents are checked by who has the parent.
core::Result<coded::CodedNode> decode_on_lattice(std::span<const std::byte> bytes, const NodeCounts& most);

}  // namespace colossus::codec
