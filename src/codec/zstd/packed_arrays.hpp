// The codec "zstd": arrays as they are, one plane per coordinate, component or channel, made small by the
// container's zstd frame alone. Readable with no code of ours; schemas/container.md describes the bytes.
#pragma once

#include <optional>

#include "codec/coded/coded_node.hpp"
#include "core/error.hpp"

namespace colossus::codec::zstd {

// Triangles in an order that graphics hardware likes, and that compresses well. Linear.
void order_for_cache(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count);

// Vertices must be in order of first use by the triangles, those that no triangle uses last; any order of
// triangles will do.
coded::Sections encode_packed(const coded::CodedNode& node);
std::optional<core::Defect> decode_packed(const coded::SectionViews& sections, coded::CodedNode& node);

}  // namespace colossus::codec::zstd
