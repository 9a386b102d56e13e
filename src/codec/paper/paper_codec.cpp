#include "codec/paper/paper_codec.hpp"

#include <algorithm>
#include <bit>

#include "codec/paper/coefficient_model.hpp"
#include "codec/paper/haar.hpp"
#include "codec/paper/strips.hpp"

namespace colossus::codec::paper {
namespace {

using core::Defect;
using mesh::Color;
using mesh::Triangle;
using Stream = std::vector<std::int64_t>;

// The numbers of a stream: so many bits, signed, or unsigned and then counted from their middle.
struct Range {
  int bits = 1;
  bool is_signed = false;
  std::int64_t middle() const { return is_signed ? 0 : std::int64_t{1} << (bits - 1); }
};

constexpr Range kByte{8, false};
constexpr Range kChroma{9, true};

// Weights can be 2^bits themselves, coordinates on the lattice cannot.
Range position_range(const coded::CodedNode& node) {
  return {node.is_on_lattice() ? std::max(1, node.position_bits) : node.position_bits + 1, false};
}

Range index_range(std::size_t count) {
  return {std::max(1, static_cast<int>(std::bit_width(count == 0 ? 0 : count - 1))), false};
}

// One stream's share of a section: transform and models.
class StreamWriter {
 public:
  explicit StreamWriter(entropy::RangeEncoder& encoder) : encoder_(encoder) {}
  void put(Stream values, const Range& range) {
    if (values.empty()) return;
    for (auto& value : values) value -= range.middle();
    haar_analyze(values);
    model_.encode(encoder_, values[0], range.bits);
    for (std::size_t step = last_haar_step(values.size()); step > 0; step /= 2)
      for (std::size_t i = step; i < values.size(); i += 2 * step)
        model_.encode(encoder_, values[i], range.bits);
  }

 private:
  entropy::RangeEncoder& encoder_;
  CoefficientModel model_;
};

class StreamReader {
 public:
  explicit StreamReader(entropy::RangeDecoder& decoder) : decoder_(decoder) {}
  // Numbers within the range, whatever the bytes.
  Stream get(std::size_t count, const Range& range) {
    Stream values(count);
    if (values.empty()) return values;
    values[0] = model_.decode(decoder_, range.bits);
    haar_synthesize(values, [&] { return model_.decode(decoder_, range.bits); });
    for (auto& value : values) value += range.middle();
    return values;
  }

 private:
  entropy::RangeDecoder& decoder_;
  CoefficientModel model_;
};

template <typename T, typename Number>
Stream stream_of(const std::vector<T>& values, Number&& number) {
  Stream stream(values.size());
  std::transform(values.begin(), values.end(), stream.begin(), number);
  return stream;
}

// Luma and chroma of YCoCg-R (Malvar, Sullivan, Srinivasan 2008), then alpha.
std::array<std::int32_t, 4> to_ycocg(const Color& color) {
  const std::int32_t co = color[0] - color[2];
  const std::int32_t t = color[2] + (co >> 1);
  const std::int32_t cg = color[1] - t;
  return {t + (cg >> 1), co, cg, color[3]};
}

// Total on numbers of 9 bits.
Color from_ycocg(const std::array<std::int32_t, 4>& ycocg) {
  const auto [y, co, cg, alpha] = ycocg;
  const std::int32_t t = y - (cg >> 1);
  const std::int32_t blue = t - (co >> 1);
  return {static_cast<std::uint8_t>(blue + co), static_cast<std::uint8_t>(cg + t),
          static_cast<std::uint8_t>(blue), static_cast<std::uint8_t>(alpha)};
}
constexpr std::array<Range, 4> kChannels{kByte, kChroma, kChroma, kByte};

// Bytes of a section, none where there is nothing to say.
template <typename Encode>
core::Bytes section_of(const coded::CodedNode& node, bool is_present, Encode&& encode) {
  if (!is_present || node.parts.empty()) return {};
  entropy::RangeEncoder encoder;
  encode(encoder);
  return encoder.finish();
}

void encode_positions(const coded::CodedNode& node, entropy::RangeEncoder& encoder) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    StreamWriter writer(encoder);
    for (const coded::CodedPart& part : node.parts)
      writer.put(
          stream_of(part.positions, [&](const coded::Coordinates& p) { return std::int64_t{p[axis]}; }),
          position_range(node));
  }
}

void decode_positions(coded::CodedNode& node, entropy::RangeDecoder& decoder) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    StreamReader reader(decoder);
    for (coded::CodedPart& part : node.parts) {
      const Stream stream = reader.get(part.positions.size(), position_range(node));
      for (std::size_t i = 0; i < stream.size(); ++i)
        part.positions[i][axis] = static_cast<std::uint32_t>(stream[i]);
    }
  }
  const auto sum = static_cast<std::uint32_t>(std::uint64_t{1} << node.position_bits);
  for (coded::CodedPart& part : node.parts)
    for (coded::Coordinates& p : part.positions) p[3] = node.is_on_lattice() ? 0 : sum - p[0] - p[1] - p[2];
}

void encode_normals(const coded::CodedNode& node, entropy::RangeEncoder& encoder) {
  for (std::size_t i = 0; i < 2; ++i) {
    StreamWriter writer(encoder);
    for (const coded::CodedPart& part : node.parts)
      writer.put(
          stream_of(part.normals, [&](const coded::OctahedralNormal& n) { return std::int64_t{n[i]}; }),
          kByte);
  }
}

void decode_normals(coded::CodedNode& node, entropy::RangeDecoder& decoder) {
  for (std::size_t i = 0; i < 2; ++i) {
    StreamReader reader(decoder);
    for (coded::CodedPart& part : node.parts) {
      const Stream stream = reader.get(part.normals.size(), kByte);
      for (std::size_t v = 0; v < stream.size(); ++v)
        part.normals[v][i] = static_cast<std::uint8_t>(stream[v]);
    }
  }
}

void encode_colors(const coded::CodedNode& node, entropy::RangeEncoder& encoder) {
  for (std::size_t channel = 0; channel < kChannels.size(); ++channel) {
    StreamWriter writer(encoder);
    for (const coded::CodedPart& part : node.parts)
      writer.put(stream_of(part.colors, [&](const Color& c) { return std::int64_t{to_ycocg(c)[channel]}; }),
                 kChannels[channel]);
  }
}

void decode_colors(coded::CodedNode& node, entropy::RangeDecoder& decoder) {
  std::vector<std::vector<std::array<std::int32_t, 4>>> converted(node.parts.size());
  for (std::size_t channel = 0; channel < kChannels.size(); ++channel) {
    StreamReader reader(decoder);
    for (std::size_t i = 0; i < node.parts.size(); ++i) {
      const Stream stream = reader.get(node.parts[i].colors.size(), kChannels[channel]);
      converted[i].resize(stream.size());
      for (std::size_t v = 0; v < stream.size(); ++v)
        converted[i][v][channel] = static_cast<std::int32_t>(stream[v]);
    }
  }
  for (std::size_t i = 0; i < node.parts.size(); ++i)
    std::transform(converted[i].begin(), converted[i].end(), node.parts[i].colors.begin(), &from_ycocg);
}

constexpr int kWidthBits = 7;  // of a number that is itself a number of bits
constexpr int kCountBits = CoefficientModel::kMaxBits;

void encode_parents(const coded::CodedNode& node, entropy::RangeEncoder& encoder) {
  CoefficientModel widths;
  StreamWriter writer(encoder);
  for (const coded::CodedPart& part : node.parts) {
    std::uint32_t all = 0;
    for (const std::uint32_t parent : part.parents) all |= parent;
    const Range range{std::max(1, static_cast<int>(std::bit_width(all))), false};
    widths.encode(encoder, range.bits, kWidthBits);
    writer.put(stream_of(part.parents, [](std::uint32_t parent) { return std::int64_t{parent}; }), range);
  }
}

std::optional<Defect> decode_parents(coded::CodedNode& node, entropy::RangeDecoder& decoder) {
  CoefficientModel widths;
  StreamReader reader(decoder);
  for (coded::CodedPart& part : node.parts) {
    const Range range{static_cast<int>(widths.decode(decoder, kWidthBits)), false};
    if (range.bits < 1 || range.bits > 32) return Defect{"the width of parents is out of range", 0};
    const Stream stream = reader.get(part.parents.size(), range);
    for (std::size_t i = 0; i < stream.size(); ++i) part.parents[i] = static_cast<std::uint32_t>(stream[i]);
  }
  return std::nullopt;
}

// A strip, and the triangles that it cannot hold as a list behind it.
void encode_triangles(const coded::CodedNode& node, entropy::RangeEncoder& encoder) {
  CoefficientModel strip_counts;
  CoefficientModel listed_counts;
  StreamWriter writer(encoder);
  for (const coded::CodedPart& part : node.parts) {
    Strip strip = strip_of(part.triangles);
    const auto listed = std::span(part.triangles).subspan(strip.triangle_count);
    strip_counts.encode(encoder, static_cast<std::int64_t>(strip.indices.size()), kCountBits);
    listed_counts.encode(encoder, static_cast<std::int64_t>(listed.size()), kCountBits);
    for (const Triangle& t : listed) strip.indices.insert(strip.indices.end(), t.begin(), t.end());
    writer.put({strip.indices.begin(), strip.indices.end()}, index_range(part.positions.size()));
  }
}

std::optional<Defect> decode_triangles(coded::CodedNode& node, entropy::RangeDecoder& decoder) {
  CoefficientModel strip_counts;
  CoefficientModel listed_counts;
  StreamReader reader(decoder);
  for (coded::CodedPart& part : node.parts) {
    const auto strip_size = static_cast<std::uint64_t>(strip_counts.decode(decoder, kCountBits));
    const auto listed = static_cast<std::uint64_t>(listed_counts.decode(decoder, kCountBits));
    if (listed > part.triangles.size() || strip_size > kMaxStripIndices * part.triangles.size())
      return Defect{"a strip is too long for its triangles", decoder.offset()};
    const Stream stream = reader.get(strip_size + 3 * listed, index_range(part.positions.size()));
    std::vector<std::uint32_t> indices(stream.size());
    for (std::size_t i = 0; i < stream.size(); ++i) {
      if (stream[i] >= static_cast<std::int64_t>(part.positions.size()))
        return Defect{"a vertex index is out of range", decoder.offset()};
      indices[i] = static_cast<std::uint32_t>(stream[i]);
    }
    const auto in_strip = std::span(part.triangles).first(part.triangles.size() - listed);
    if (triangles_of_strip(std::span(indices).first(strip_size), in_strip) != in_strip.size())
      return Defect{"a strip has not as many triangles as it should", decoder.offset()};
    for (std::size_t i = 0; i < 3 * listed; ++i)
      part.triangles[in_strip.size() + i / 3][i % 3] = indices[strip_size + i];
  }
  return std::nullopt;
}

// None if `decode` read the section to its end, but not beyond.
template <typename Decode>
std::optional<Defect> decode_section(const coded::CodedNode& node, bool is_present,
                                     std::span<const std::byte> section, Decode&& decode) {
  if (!is_present || node.parts.empty())
    return section.empty() ? std::nullopt : std::optional(Defect{"a section should be empty", 0});
  entropy::RangeDecoder decoder(section);
  if (std::optional<Defect> defect = decode(decoder)) return defect;
  if (decoder.offset() != section.size())
    return Defect{fmt::format("a section has {} bytes, expected {}", section.size(), decoder.offset()),
                  std::min<std::uint64_t>(decoder.offset(), section.size())};
  return std::nullopt;
}

}  // namespace

coded::Sections encode_paper(const coded::CodedNode& node) {
  coded::Sections sections;
  const auto put = [&](coded::Component component, bool is_present, auto&& encode) {
    sections[static_cast<std::size_t>(component)] =
        section_of(node, is_present, [&](entropy::RangeEncoder& encoder) { encode(node, encoder); });
  };
  put(coded::Component::kPositions, true, encode_positions);
  put(coded::Component::kNormals, node.has_normals, encode_normals);
  put(coded::Component::kColors, node.has_colors, encode_colors);
  put(coded::Component::kParents, node.has_parents, encode_parents);
  put(coded::Component::kConnectivity, true, encode_triangles);
  return sections;
}

std::optional<Defect> decode_paper(const coded::SectionViews& sections, coded::CodedNode& node) {
  const auto get = [&](coded::Component component, bool is_present, auto&& decode) {
    return decode_section(node, is_present, sections[static_cast<std::size_t>(component)],
                          [&](entropy::RangeDecoder& decoder) -> std::optional<Defect> {
                            if constexpr (std::is_void_v<decltype(decode(node, decoder))>) {
                              decode(node, decoder);
                              return std::nullopt;
                            } else {
                              return decode(node, decoder);
                            }
                          });
  };
  std::optional<Defect> defect = get(coded::Component::kPositions, true, decode_positions);
  if (!defect) defect = get(coded::Component::kNormals, node.has_normals, decode_normals);
  if (!defect) defect = get(coded::Component::kColors, node.has_colors, decode_colors);
  if (!defect) defect = get(coded::Component::kParents, node.has_parents, decode_parents);
  if (!defect) defect = get(coded::Component::kConnectivity, true, decode_triangles);
  return defect;
}

}  // namespace colossus::codec::paper
