// What a codec codes: the meshes of one node, of whatever scheme, as indexed triangles with integer
// attributes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/bytes.hpp"
#include "geometry/point.hpp"
#include "mesh/mesh.hpp"

namespace colossus::codec::coded {

// What the bytes of a payload are spent on, each in a section of its own.
enum class Component : std::uint8_t { kConnectivity, kPositions, kNormals, kColors, kParents };
inline constexpr std::size_t kComponentCount = 5;
template <typename T>
using PerComponent = std::array<T, kComponentCount>;
// The columns of a container's levels that say what sections take.
inline constexpr PerComponent<const char*> kComponentColumns{"connectivity_bytes", "position_bytes",
                                                             "normal_bytes", "color_bytes", "parent_bytes"};

using Coordinates = std::array<std::uint32_t, 4>;
using OctahedralNormal = std::array<std::uint8_t, 2>;

// Row i is the direction in space in which coordinate i of a position leads, up to a common factor. It helps
// prediction and changes nothing else.
using Frame = std::array<std::array<std::int8_t, 3>, 3>;
inline constexpr Frame kIdentityFrame{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
inline constexpr int kGreatestFrameEntry = 2;

// What the coordinates of a position are.
enum class PositionKind : std::uint8_t {
  kWeights,  // those of four corners, which sum to 2^position_bits; see weights.hpp
  kLattice,  // x, y and z below 2^position_bits, to be added to the node's offset, and a 0;
             // see lattice_node.hpp
};

// Triangles with vertices of their own. Vertex arrays have one entry per vertex, or none where the attribute
// is absent; as they are stored, vertices are in order of first use by the triangles. Only on the lattice
// there may be some that no triangle uses; they come last.
struct CodedPart {
  std::uint8_t place = 0;  // which of the node's tetrahedra the weights are of
  Frame frame = kIdentityFrame;
  std::vector<Coordinates> positions;
  std::vector<OctahedralNormal> normals;
  std::vector<mesh::Color> colors;
  std::vector<std::uint32_t> parents;  // numbers of vertices of the parent node
  std::vector<mesh::Triangle> triangles;
  friend bool operator==(const CodedPart&, const CodedPart&) = default;
};

struct CodedNode {
  PositionKind position_kind = PositionKind::kWeights;
  int position_bits = 0;
  bool has_normals = false;
  bool has_colors = false;
  bool has_parents = false;
  geometry::Point offset;        // of positions on the lattice
  std::vector<CodedPart> parts;  // by ascending place; on the lattice one, at place 0 with the identity
  bool is_on_lattice() const { return position_kind == PositionKind::kLattice; }
  friend bool operator==(const CodedNode&, const CodedNode&) = default;
};

// With all that the node holds.
std::size_t memory_bytes(const CodedNode& node);

// One for each component, empty where there is nothing to say.
using Sections = PerComponent<core::Bytes>;
using SectionViews = PerComponent<std::span<const std::byte>>;

}  // namespace colossus::codec::coded
