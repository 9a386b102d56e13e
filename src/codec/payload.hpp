// A node's bytes: a head that all codecs share, the codec's sections, a checksum. schemas/container.md
// describes them.
#pragma once

#include "codec/codec.hpp"

namespace colossus::codec {

// A node's bytes, and how many of them are spent on what; head and checksum are the rest.
struct Payload {
  core::Bytes bytes;
  // Where the head and each section end.
  std::array<std::size_t, coded::kComponentCount + 1> cuts{};
};

// What a node may decode to at most: what the node table says of it.
struct NodeCounts {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

Payload to_payload(const coded::CodedNode& node, const Codec& codec);

// Total on any bytes. Reads what every codec has written; a Defect when the bytes are not exactly that, so
// that any damage is noticed, or when they hold more than `most`. Memory is that of the result, within
// `most`, and a small multiple of it.
core::Result<coded::CodedNode> from_payload(std::span<const std::byte> bytes, const NodeCounts& most);

}  // namespace colossus::codec
