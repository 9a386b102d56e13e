// The table of codecs: the one place that knows all of them, and whatever differs between them. A payload
// begins with its codec's id and version; schemas/container.md describes the bytes.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "codec/coded/coded_node.hpp"
#include "core/error.hpp"

namespace colossus::codec {

// The position bits of the measurements below.
inline constexpr int kMeasuredPositionBits = 12;

// What a codec's payloads take in a container, in bytes per triangle of a large node: measured on statues, so
// that a build can be estimated.
struct MeasuredBytes {
  double triangle = 0.0;     // with colours and positions of kMeasuredPositionBits
  double finer_bit = 0.0;    // more for each bit beyond these
  double coarser_bit = 0.0;  // less for each bit short of them
  double color = 0.0;        // less without colours
};

struct Codec {
  const char* name;
  std::uint8_t id;
  std::uint8_t version;
  // At which a container's frame around the payload is compressed: fast where the bytes are small already.
  int zstd_level;
  MeasuredBytes measured;  // nothing where the version is only read
  // Puts triangles, and with them vertices by first use, into the order that encode() wants; corners keep
  // their cyclic order. Deterministic; a second time it changes nothing where encode() wants more than first
  // use.
  void (*order)(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count);
  // The parts' triangles must be as order() leaves them; anything else is a bug and ends the program.
  coded::Sections (*encode)(const coded::CodedNode& node);
  // Fills the arrays of the parts, which have the right sizes; everything else about the node is known.
  // Total on any bytes, and no slower than linear in bytes and counts. What comes back may break what
  // CodedPart says of order, but indices are in range.
  std::optional<core::Defect> (*decode)(const coded::SectionViews& sections, coded::CodedNode& node);
};

// All of them in their present versions, the default one first.
std::span<const Codec> codecs();
// Those that are only read: their order and encode are null.
std::span<const Codec> old_versions();

// Throws Error(kUsage) that lists the codecs when there is none of this name.
const Codec& codec_named(std::string_view name);

// Of these bytes' first two. A Defect that says what this program reads when it does not know them.
core::Result<const Codec*> codec_of(std::span<const std::byte> payload);

}  // namespace colossus::codec
