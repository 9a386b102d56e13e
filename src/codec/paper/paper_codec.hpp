// The codec "paper": that of Balsa Rodriguez et al., "Compression-domain seamless multiresolution
// visualization of gigantic triangle meshes on mobile devices" (2013), section 4.4, complete: the baseline
// that ours is compared with. Vertices in the order of strips, streams of one component each, a Haar-like
// transform of each, a range coder. schemas/container.md describes the bytes.
#pragma once

#include <optional>

#include "codec/coded/coded_node.hpp"
#include "core/error.hpp"

namespace colossus::codec::paper {

// Any order of triangles and vertices will do; that of order_in_strips(), with vertices by first use, makes
// few bytes. Linear.
coded::Sections encode_paper(const coded::CodedNode& node);
std::optional<core::Defect> decode_paper(const coded::SectionViews& sections, coded::CodedNode& node);

}  // namespace colossus::codec::paper
