#include "codec/zstd/packed_arrays.hpp"

#include <meshoptimizer.h>

#include <algorithm>

namespace colossus::codec::zstd {
namespace {

using core::ByteReader;
using core::ByteWriter;
using core::Defect;

// 1, 2 or 4: the narrowest that holds this and all smaller numbers.
std::size_t narrowest_bytes(std::size_t largest) { return largest <= 0xff ? 1 : largest <= 0xffff ? 2 : 4; }

// Calls with a value of the unsigned type of so many bytes, so that loops over arrays know it.
template <typename Use>
auto with_type(std::size_t bytes, Use use) {
  if (bytes == 1) return use(std::uint8_t{});
  if (bytes == 2) return use(std::uint16_t{});
  return use(std::uint32_t{});
}

void put_sized(ByteWriter& writer, std::uint32_t value, std::size_t bytes) {
  writer.put_bytes(std::as_bytes(std::span<const std::uint32_t, 1>(&value, 1)).first(bytes));
}

template <typename T>
std::uint32_t get_at(std::span<const std::byte> plane, std::size_t index) {
  T value = 0;
  std::memcpy(&value, plane.data() + index * sizeof(T), sizeof(T));
  return value;
}

template <std::size_t kChannels>
void put_planes(ByteWriter& writer, const std::vector<std::array<std::uint8_t, kChannels>>& values) {
  for (std::size_t channel = 0; channel < kChannels; ++channel)
    for (const auto& value : values) writer.put(value[channel]);
}

template <std::size_t kChannels>
bool get_planes(ByteReader& reader, std::vector<std::array<std::uint8_t, kChannels>>& values) {
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    const auto plane = reader.get_bytes(values.size());
    if (reader.failed()) return false;
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i][channel] = std::to_integer<std::uint8_t>(plane[i]);
  }
  return true;
}

// Weights can be 2^bits themselves, coordinates on the lattice cannot.
std::size_t position_bytes(const coded::CodedNode& node) {
  return narrowest_bytes((std::uint64_t{1} << node.position_bits) - (node.is_on_lattice() ? 1 : 0));
}

bool get_positions(ByteReader& reader, const coded::CodedNode& node,
                   std::vector<coded::Coordinates>& positions) {
  const std::size_t size = position_bytes(node);
  std::array<std::span<const std::byte>, 3> planes;
  for (auto& plane : planes) plane = reader.get_bytes(positions.size() * size);
  if (reader.failed()) return false;
  const std::uint32_t one = 1U << (node.position_bits & 31);  // of weights alone
  with_type(size, [&]<typename T>(T) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      coded::Coordinates& p = positions[i];
      for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = get_at<T>(planes[axis], i);
      p[3] = node.is_on_lattice() ? 0 : one - p[0] - p[1] - p[2];
    }
  });
  return true;
}

// A code can be as large as the number of vertices: vertex 0, seen after the last new one.
void put_triangles(ByteWriter& writer, const coded::CodedPart& part) {
  // Counted back from the highest index so far: small numbers, 0 for a new vertex.
  std::uint32_t high_water = 0;
  const std::size_t size = narrowest_bytes(part.positions.size());
  for (const mesh::Triangle& t : part.triangles)
    for (const std::uint32_t v : t) {
      COLOSSUS_CHECK(v <= high_water, "vertices are not in order of first use");
      put_sized(writer, high_water - v, size);
      if (v == high_water) ++high_water;
    }
  COLOSSUS_CHECK(high_water <= part.positions.size(), "vertex {} of {}", high_water - 1,
                 part.positions.size());
}

std::optional<Defect> get_triangles(ByteReader& reader, coded::CodedPart& part) {
  const std::uint64_t start = reader.offset();
  const std::size_t size = narrowest_bytes(part.positions.size());
  const auto codes = reader.get_bytes(3 * part.triangles.size() * size);
  if (reader.failed()) return Defect{"the triangles are cut short", start};
  const std::size_t count = part.positions.size();
  return with_type(size, [&]<typename T>(T) -> std::optional<Defect> {
    std::uint32_t high_water = 0;
    std::size_t corner = 0;
    for (mesh::Triangle& t : part.triangles)
      for (auto& v : t) {
        const std::uint32_t back = get_at<T>(codes, corner);
        if (back > high_water || (back == 0 && high_water >= count))
          return Defect{"a vertex index is out of range", start + corner * size};
        v = high_water - back;
        high_water += back == 0 ? 1 : 0;
        ++corner;
      }
    return std::nullopt;
  });
}

// Their width first, in one byte.
void put_parents(ByteWriter& writer, const coded::CodedPart& part) {
  const auto greatest = std::max_element(part.parents.begin(), part.parents.end());
  const std::size_t size = narrowest_bytes(greatest == part.parents.end() ? 0 : *greatest);
  writer.put(static_cast<std::uint8_t>(size));
  for (const std::uint32_t parent : part.parents) put_sized(writer, parent, size);
}

bool get_parents(ByteReader& reader, coded::CodedPart& part) {
  const std::size_t size = reader.get<std::uint8_t>();
  if (size != 1 && size != 2 && size != 4) return false;
  const auto plane = reader.get_bytes(part.parents.size() * size);
  if (reader.failed()) return false;
  with_type(size, [&]<typename T>(T) {
    for (std::size_t i = 0; i < part.parents.size(); ++i) part.parents[i] = get_at<T>(plane, i);
  });
  return true;
}

}  // namespace

void order_for_cache(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count) {
  if (triangles.empty()) return;
  std::vector<unsigned int> ordered(triangles.size() * 3);
  meshopt_optimizeVertexCache(ordered.data(), triangles.front().data(), ordered.size(), vertex_count);
  std::copy(ordered.begin(), ordered.end(), triangles.front().data());
}

coded::Sections encode_packed(const coded::CodedNode& node) {
  coded::PerComponent<ByteWriter> writers;
  const auto writer = [&](coded::Component component) -> ByteWriter& {
    return writers[static_cast<std::size_t>(component)];
  };
  for (const coded::CodedPart& part : node.parts) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const coded::Coordinates& p : part.positions)
        put_sized(writer(coded::Component::kPositions), p[axis], position_bytes(node));
    put_planes(writer(coded::Component::kNormals), part.normals);
    put_planes(writer(coded::Component::kColors), part.colors);
    if (node.has_parents) put_parents(writer(coded::Component::kParents), part);
    put_triangles(writer(coded::Component::kConnectivity), part);
  }
  coded::Sections sections;
  for (std::size_t i = 0; i < coded::kComponentCount; ++i) sections[i] = writers[i].take();
  return sections;
}

std::optional<Defect> decode_packed(const coded::SectionViews& sections, coded::CodedNode& node) {
  coded::PerComponent<ByteReader> readers{ByteReader(sections[0]), ByteReader(sections[1]),
                                          ByteReader(sections[2]), ByteReader(sections[3]),
                                          ByteReader(sections[4])};
  const auto reader = [&](coded::Component component) -> ByteReader& {
    return readers[static_cast<std::size_t>(component)];
  };
  const auto cut_short = [&](coded::Component component, const char* what) {
    return Defect{fmt::format("the {} are cut short", what), reader(component).offset()};
  };
  for (coded::CodedPart& part : node.parts) {
    if (!get_positions(reader(coded::Component::kPositions), node, part.positions))
      return cut_short(coded::Component::kPositions, "positions");
    if (!get_planes(reader(coded::Component::kNormals), part.normals))
      return cut_short(coded::Component::kNormals, "normals");
    if (!get_planes(reader(coded::Component::kColors), part.colors))
      return cut_short(coded::Component::kColors, "colours");
    if (node.has_parents && !get_parents(reader(coded::Component::kParents), part))
      return cut_short(coded::Component::kParents, "parents");
    if (auto defect = get_triangles(reader(coded::Component::kConnectivity), part)) return defect;
  }
  for (const ByteReader& r : readers)
    if (r.remaining() != 0) return Defect{"bytes left over in a section", r.offset()};
  return std::nullopt;
}

}  // namespace colossus::codec::zstd
