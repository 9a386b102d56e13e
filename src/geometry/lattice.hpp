// The integer lattice on which all positions of a container live: a power-of-two step and an origin in
// doubles.
//
// Input vertices are put at residues (1, 2, 4) modulo 8 in x, y, z. The corners of all cells lie at multiples
// of 8, and the planes of the hierarchy have normals e_i or e_i +- e_j: no sum or difference of two of these
// residues is 0 modulo 8, so no input vertex ever lies on a plane. It costs three of the 30 bits.
#pragma once

#include <array>

#include "geometry/point.hpp"

namespace colossus::geometry {

inline constexpr std::int32_t kInputSpacing = 8;
inline constexpr std::array<std::int32_t, 3> kInputResidue{1, 2, 4};

struct Lattice {
  std::array<double, 3> origin{};  // world position of lattice point (0, 0, 0)
  double step = 1.0;               // world units per lattice unit, a power of two

  // The finest lattice whose root cube holds `bounds` strictly inside; never finer than the doubles of the
  // bounds. `bounds` must not be empty and must be finite.
  static Lattice fit(const Bounds& bounds);

  // The input vertex nearest to a world position inside the bounds that the lattice was fitted to.
  Point input_vertex(const std::array<double, 3>& world) const;

  std::array<double, 3> world(const std::array<double, 3>& lattice_position) const {
    return {origin[0] + step * lattice_position[0], origin[1] + step * lattice_position[1],
            origin[2] + step * lattice_position[2]};
  }

  // Largest distance, in world units, between a world position and its input vertex.
  double input_error() const;
};

}  // namespace colossus::geometry
