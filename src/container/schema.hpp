// What a container holds besides the nodes' chunks: the node table and the metadata. schemas/container.md
// describes how each of them lies in the file; a change here changes the schema version there.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/version.hpp"

namespace colossus::container {

// A reader refuses a larger major version. A larger minor version only adds fields, attributes and datasets.
inline constexpr std::uint32_t kSchemaMajor = 1;
inline constexpr std::uint32_t kSchemaMinor = 2;

inline constexpr const char* kFormatName = "colossus";
inline constexpr const char* kProducerName = "colossus";

inline constexpr std::uint8_t kNodeIsLeaf = 1;  // NodeRow::flags: no node below this one
inline constexpr std::uint8_t kNodeIsAboveLimit =
    2;  // NodeRow::flags: a leaf that no bisection could thin out; diamonds only

// One node: its place, what is needed to decide whether to read it, and where its bytes lie.
struct NodeRow {
  std::uint32_t level = 0;
  std::array<std::int32_t, 3> center{};  // lattice coordinates
  // Diamonds: bit p: the tetrahedron at place p exists: the input's surface crosses it. Blocks: 1.
  std::uint8_t tetra_mask = 0;
  std::uint8_t flags = 0;      // kNodeIsLeaf, kNodeIsAboveLimit
  std::uint32_t vertices = 0;  // sum over the diamond's tetrahedra, or of the cube
  std::uint32_t triangles = 0;
  double error = 0;                  // world units; of distances both ways; never smaller than a child's
  std::array<double, 6> bounds{};    // world: min x, y, z, max x, y, z
  std::uint32_t capacity_class = 0;  // the chunk lies in the dataset /chunks/class_<capacity_class>
  std::uint32_t chunk_index = 0;     // ... where it is the chunk of this number; the writer sets it
  // Of the frame in the file, in bytes; the writer sets it. Copies may have it elsewhere:
  // ContainerReader::frame_offset().
  std::uint64_t offset = 0;
  std::uint64_t stored_bytes = 0;   // size of the frame
  std::uint64_t payload_bytes = 0;  // size of what unpack_chunk() returns
  std::uint64_t checksum = 0;       // XXH3-64 of the frame
  friend bool operator==(const NodeRow&, const NodeRow&) = default;
};

// World position = origin + step * lattice position, per axis. The root cube is [0, 2^root_bits]^3.
struct LatticeInfo {
  std::array<double, 3> origin{};
  double step = 1;
  int root_bits = 1;  // 1 .. 30
  friend bool operator==(const LatticeInfo&, const LatticeInfo&) = default;
};

struct NamedText {
  std::string name;
  std::string value;
  friend bool operator==(const NamedText&, const NamedText&) = default;
};

struct NamedCount {
  std::string name;
  std::uint64_t value = 0;
  friend bool operator==(const NamedCount&, const NamedCount&) = default;
};

struct NamedReal {
  std::string name;
  double value = 0;
  friend bool operator==(const NamedReal&, const NamedReal&) = default;
};

struct InputInfo {
  std::string name;  // without folders
  std::uint64_t bytes = 0;
  std::string hash;  // XXH3-128 of the content, 32 hexadecimal digits, high half first
  friend bool operator==(const InputInfo&, const InputInfo&) = default;
};

// A column of the statistics per level, one value per level from the root on.
struct LevelColumn {
  std::string name;
  std::variant<std::vector<std::uint64_t>, std::vector<double>> values;
  friend bool operator==(const LevelColumn&, const LevelColumn&) = default;
};

// Nothing in here may depend on how the container was built (ranks, hosts, times): equal inputs and options
// give equal bytes. Strings hold no zero bytes; columns have equal lengths.
struct Metadata {
  std::uint32_t schema_major = kSchemaMajor;  // the writer writes its own version, whatever stands here
  std::uint32_t schema_minor = kSchemaMinor;
  // Likewise; empty in containers from before schema 1.2, which did not say it.
  std::string producer = kProducerName;
  std::string producer_version = core::release_version();
  std::string scheme;  // whose node table and chunks these are; the tables of schemes say which there are
  LatticeInfo lattice;
  int position_bits = 12;  // 8 .. 16; of the weights of diamonds, of a side of the deepest cubes of blocks
  bool has_normals = false;
  bool has_colors = false;
  std::vector<NamedText> options;  // those that shape the bytes, in a fixed order
  // What options mean that only the scheme knows: for who looks into the file; not read back.
  std::vector<NamedText> option_meanings;
  std::vector<NamedReal> parameters;  // of the scheme, such as sigma0 of blocks; in a fixed order
  std::vector<NamedReal> measures;    // of the input and of the finest level, such as areas; in a fixed order
  std::vector<InputInfo> inputs;      // in the order of reading
  std::vector<NamedCount>
      counts;  // of the input: vertices, triangles, degenerate, duplicate, border edges ...
  std::vector<LevelColumn> levels;
  friend bool operator==(const Metadata&, const Metadata&) = default;
};

}  // namespace colossus::container
