// The header of a PLY file. Types, counts and names as declared; nothing of the body is looked at.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.hpp"

namespace colossus::input {

// The 64-bit integers are no part of the format, but some writers use them.
enum class PlyType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64
};

constexpr std::size_t ply_size(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}
constexpr bool is_float(PlyType type) { return type == PlyType::kFloat32 || type == PlyType::kFloat64; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  // of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // of a list's count; an integer, unless lenient
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  bool has_list = false;
  std::size_t row_bytes = 0;  // of a row in a binary file, if all its lists are empty: exact if it has none

  // Index of a property, or -1.
  int find(std::string_view property) const;
};

enum class PlyFormat : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string> texture_comments;  // "comment TextureFile ..." as they stand
  bool has_object_info = false;               // obj_info
  std::uint64_t prose_lines = 0;              // without a keyword
  std::uint64_t first_prose_line = 0;         // from 1
  std::uint64_t bytes = 0;                    // the body starts here

  // The element, or nullptr.
  const PlyElement* find(std::string_view element) const;
};

// Lines may end with \n, \r\n or \r (as the first one does); a byte order mark may come first. Throws
// core::Error(kBadData) that names the line for anything else than format 1.0, elements and properties with
// distinct names, comment and obj_info, but for prose if `is_lenient`, and for a header of more than 1 MiB.
PlyHeader read_ply_header(const core::File& file, bool is_lenient);

}  // namespace colossus::input
