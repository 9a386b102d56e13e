// Tells positions apart that only the lattice lets coincide.
//
// Two vertices of the input are one point if their coordinates are equal as doubles. On the lattice they may
// be one although they are not: then two opposite triangles over them are two sides of something thin, and
// not a surface that was written twice. So until duplicates have been found, a vertex carries 15 bits of a
// hash of its coordinates. Two corners that differ go for the same once in 2^15; what follows is that one
// side of a thin thing stays instead of both, or that a triangle smaller than a cell of the lattice is called
// degenerate. The bits cost nothing in scratch: lattice positions of the input have known residues modulo 8
// (geometry/lattice.hpp), and never use their two highest bits.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "core/hash.hpp"
#include "geometry/lattice.hpp"
#include "mesh/mesh.hpp"

namespace colossus::pipeline::facts {

inline constexpr int kFingerprintBits = 15;

inline std::uint16_t fingerprint_of(const std::array<double, 3>& position) {
  std::uint64_t hash = 0;
  // + 0.0: a negative zero is the same place as a positive one.
  for (const double c : position)
    hash = core::mix64(hash + 0x9e3779b97f4a7c15ULL + std::bit_cast<std::uint64_t>(c + 0.0));
  return static_cast<std::uint16_t>(hash >> (64 - kFingerprintBits));
}

// A position on the lattice, as Lattice::input_vertex() makes it, with a fingerprint in the bits that say
// nothing: five of each coordinate.
inline geometry::Point with_fingerprint(const geometry::Point& p, std::uint16_t fingerprint) {
  geometry::Point packed;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint32_t bits = fingerprint >> (5 * axis) & 31U;
    packed[axis] = static_cast<std::int32_t>((static_cast<std::uint32_t>(p[axis]) & ~7U) | (bits & 7U) |
                                             (bits >> 3) << geometry::kRootBits);
  }
  return packed;
}

// The inverse: sets position and fingerprint.
inline void take_apart(const geometry::Point& packed, mesh::Vertex& vertex) {
  std::uint32_t fingerprint = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto c = static_cast<std::uint32_t>(packed[axis]);
    fingerprint |= ((c & 7U) | (c >> geometry::kRootBits) << 3) << (5 * axis);
    vertex.position[axis] = static_cast<std::int32_t>(
        (c & ((1U << geometry::kRootBits) - 1U) & ~7U) |
        static_cast<std::uint32_t>(geometry::kInputResidue[static_cast<std::size_t>(axis)]));
  }
  vertex.fingerprint = static_cast<std::uint16_t>(fingerprint);
}

}  // namespace colossus::pipeline::facts
