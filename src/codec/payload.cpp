#include "codec/payload.hpp"

#include "core/hash.hpp"

namespace colossus::codec {
namespace {

using core::ByteReader;
using core::ByteWriter;
using core::Defect;

constexpr std::uint8_t kNormalsFlag = 1;
constexpr std::uint8_t kColorsFlag = 2;
constexpr std::uint8_t kParentsFlag = 4;
constexpr std::uint8_t kLatticeFlag = 8;
constexpr std::uint8_t kAllFlags = 15;
constexpr std::uint8_t kMaxPlaces = 8;
constexpr std::size_t kChecksumBytes = sizeof(std::uint64_t);

// Nine digits of base 5.
constexpr std::uint32_t kFrameBase = 2 * coded::kGreatestFrameEntry + 1;
constexpr std::uint32_t kFrameCount = 1953125;

std::uint32_t frame_number(const coded::Frame& frame) {
  std::uint32_t number = 0;
  for (const auto& row : frame)
    for (const int entry : row) {
      COLOSSUS_CHECK(entry >= -coded::kGreatestFrameEntry && entry <= coded::kGreatestFrameEntry,
                     "frame entry {}", entry);
      number = number * kFrameBase + static_cast<std::uint32_t>(entry + coded::kGreatestFrameEntry);
    }
  return number;
}

coded::Frame frame_of_number(std::uint32_t number) {
  coded::Frame frame{};
  for (std::size_t i = 9; i-- > 0; number /= kFrameBase)
    frame[i / 3][i % 3] =
        static_cast<std::int8_t>(static_cast<int>(number % kFrameBase) - coded::kGreatestFrameEntry);
  return frame;
}

struct Head {
  coded::CodedNode node;  // without arrays
  struct Counts {
    std::uint32_t vertices = 0;
    std::uint32_t triangles = 0;
  };
  std::vector<Counts> counts;  // of the parts
  coded::PerComponent<std::uint32_t> section_bytes{};
};

void put_head(ByteWriter& writer, const coded::CodedNode& node, const Codec& codec,
              const coded::Sections& sections) {
  writer.put(codec.id);
  writer.put(codec.version);
  writer.put(static_cast<std::uint8_t>(node.position_bits));
  writer.put(static_cast<std::uint8_t>(
      (node.has_normals ? kNormalsFlag : 0) | (node.has_colors ? kColorsFlag : 0) |
      (node.has_parents ? kParentsFlag : 0) | (node.is_on_lattice() ? kLatticeFlag : 0)));
  writer.put(static_cast<std::uint8_t>(node.parts.size()));
  for (const coded::CodedPart& part : node.parts) {
    // Place and frame in one number of four bytes.
    writer.put(std::uint32_t{part.place} << 24 | frame_number(part.frame));
    writer.put(static_cast<std::uint32_t>(part.positions.size()));
    writer.put(static_cast<std::uint32_t>(part.triangles.size()));
  }
  if (node.is_on_lattice()) writer.put(node.offset);
  for (const core::Bytes& section : sections) writer.put(static_cast<std::uint32_t>(section.size()));
}

core::Result<Head> get_head(ByteReader& reader) {
  Head head;
  coded::CodedNode& node = head.node;
  reader.get<std::uint16_t>();  // codec_of() has looked at it
  node.position_bits = reader.get<std::uint8_t>();
  const auto flags = reader.get<std::uint8_t>();
  const auto count = reader.get<std::uint8_t>();
  if (reader.failed()) return Defect{"the payload's head is cut short", 0};
  if (node.position_bits > 32) return Defect{"position bits out of range", 2};
  if (flags > kAllFlags) return Defect{"unknown flags", 3};
  node.has_normals = (flags & kNormalsFlag) != 0;
  node.has_colors = (flags & kColorsFlag) != 0;
  node.has_parents = (flags & kParentsFlag) != 0;
  node.position_kind =
      (flags & kLatticeFlag) != 0 ? coded::PositionKind::kLattice : coded::PositionKind::kWeights;
  if (node.is_on_lattice() ? count != 1 : count > kMaxPlaces) return Defect{"too many parts", 4};
  for (int i = 0; i < count; ++i) {
    const auto place_and_frame = reader.get<std::uint32_t>();
    const auto vertices = reader.get<std::uint32_t>();
    const auto triangles = reader.get<std::uint32_t>();
    coded::CodedPart part;
    part.place = static_cast<std::uint8_t>(place_and_frame >> 24);
    if (part.place >= kMaxPlaces || (i > 0 && part.place <= node.parts.back().place))
      return Defect{"parts are not in order of their places", reader.offset()};
    const std::uint32_t number = place_and_frame & 0xffffff;
    if (number >= kFrameCount) return Defect{"a frame is out of range", reader.offset()};
    part.frame = frame_of_number(number);
    node.parts.push_back(std::move(part));
    head.counts.push_back({vertices, triangles});
  }
  if (node.is_on_lattice()) {
    node.offset = reader.get<geometry::Point>();
    if (node.parts[0].place != 0 || node.parts[0].frame != coded::kIdentityFrame)
      return Defect{"positions on the lattice have a place or a frame", 5};
  }
  for (auto& bytes : head.section_bytes) bytes = reader.get<std::uint32_t>();
  if (reader.failed()) return Defect{"the payload's head is cut short", reader.offset()};
  return head;
}

std::optional<Defect> resize_arrays(Head& head, const NodeCounts& most) {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  for (const auto& counts : head.counts) {
    vertices += counts.vertices;
    triangles += counts.triangles;
  }
  if (vertices > most.vertices || triangles > most.triangles)
    return Defect{fmt::format("it holds {} vertices and {} triangles; expected at most {} and {}", vertices,
                              triangles, most.vertices, most.triangles),
                  5};
  for (std::size_t i = 0; i < head.counts.size(); ++i) {
    coded::CodedPart& part = head.node.parts[i];
    const std::size_t n = head.counts[i].vertices;
    part.positions.resize(n);
    part.normals.resize(head.node.has_normals ? n : 0);
    part.colors.resize(head.node.has_colors ? n : 0);
    part.parents.resize(head.node.has_parents ? n : 0);
    part.triangles.resize(head.counts[i].triangles);
  }
  return std::nullopt;
}

}  // namespace

Payload to_payload(const coded::CodedNode& node, const Codec& codec) {
  const coded::Sections sections = codec.encode(node);
  ByteWriter writer;
  put_head(writer, node, codec, sections);
  Payload payload;
  payload.cuts[0] = writer.size();
  for (std::size_t i = 0; i < coded::kComponentCount; ++i) {
    writer.put_bytes(sections[i]);
    payload.cuts[i + 1] = writer.size();
  }
  writer.put(core::hash64(writer.bytes()));
  payload.bytes = writer.take();
  return payload;
}

core::Result<coded::CodedNode> from_payload(std::span<const std::byte> bytes, const NodeCounts& most) {
  const auto codec = codec_of(bytes);
  if (!codec) return codec.defect();
  if (bytes.size() < kChecksumBytes) return Defect{"the payload is cut short", bytes.size()};
  const auto content = bytes.first(bytes.size() - kChecksumBytes);
  if (ByteReader(bytes.last(kChecksumBytes)).get<std::uint64_t>() != core::hash64(content))
    return Defect{"the payload's checksum is not that of its bytes", content.size()};
  ByteReader reader(content);
  auto head = get_head(reader);
  if (!head) return head.defect();
  coded::SectionViews sections;
  for (std::size_t i = 0; i < coded::kComponentCount; ++i)
    sections[i] = reader.get_bytes(head.value().section_bytes[i]);
  if (reader.failed()) return Defect{"a section is cut short", reader.offset()};
  if (reader.remaining() != 0) return Defect{"bytes left over after the last section", reader.offset()};
  if (auto defect = resize_arrays(head.value(), most)) return *std::move(defect);
  if (auto defect = codec.value()->decode(sections, head.value().node)) return *std::move(defect);
  return std::move(head.value().node);
}

}  // namespace colossus::codec
