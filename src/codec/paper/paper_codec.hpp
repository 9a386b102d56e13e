// The codec "paper": that of Balsa Rodriguez et al., "Compression-domain seamless multiresolution
// visualization of gigantic triangle meshes on mobile devices" (2013), section 4.4, complete: the baseline
// that ours is compared with. Vertices in the order of strips, streams of one component each, a Haar-like
// transform of each, a range coder. schemas/container.md describes the bytes.
#pragma once

#include <optional>

#include "codec/coded_node.hpp"
#include "core/error.hpp"

namespace colossus::codec {

// Any order of triangles and vertices will do; that of order_in_strips(), with vertices by first use, makes
// few bytes. Linear.
Sections encode_paper(const CodedNode& node);
std::optional<core::Defect> decode_paper(const SectionViews& sections, CodedNode& node);

}  // namespace colossus::codec
