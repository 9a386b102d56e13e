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

// One tetrahedron, or one cube. Vertex arrays have one entry per vertex, or none where the attribute is
// absent; vertices are in order of first use by the triangles. Of a cube those that no triangle uses come
// last, of a tetrahedron there are none.
struct CodedPart {
  std::uint8_t place = 0;  // of a tetrahedron in its diamond
  Frame frame = kIdentityFrame;
  // Of a tetrahedron weights, which sum to 2^position_bits; of a cube x, y and z below 2^position_bits, and
  // 0.
  std::vector<Coordinates> positions;
  std::vector<OctahedralNormal> normals;
  std::vector<mesh::Color> colors;
  std::vector<std::uint32_t> parents;
  std::vector<mesh::Triangle> triangles;
};

struct CodedNode {
  bool is_cube = false;  // one part with the identity as its frame; else tetrahedra by ascending place
  int position_bits = 0;
  bool has_normals = false;
  bool has_colors = false;
  bool has_parents = false;
  geometry::Point offset;  // of a cube, to be added to its positions
  std::vector<CodedPart> parts;
};

// One for each component, empty where there is nothing to say.
using Sections = PerComponent<core::Bytes>;
using SectionViews = PerComponent<std::span<const std::byte>>;

}  // namespace colossus::codec::coded
