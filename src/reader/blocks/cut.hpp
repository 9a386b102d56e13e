// Cuts of the blocks scheme: which cubes are drawn, and how their vertices are morphed (Li 2024, sections
// 4.2.1 and 4.2.2).
//
// We depart from Li's distance from eye to cube, which is wrong where the eye lies within the cube's
// slab on an axis: it is the largest over the axes of max(low - c, 0, c - high).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reader/access/eye.hpp"
#include "reader/blocks/statue.hpp"

namespace colossus::reader::blocks {

// Where vertices go for an eye. All lengths in lattice units.
class Morph {
 public:
  // `eye` is rounded to a multiple of 2^-20 of the lattice's step (or more, farther away than 2^32 steps), so
  // that its distances to points and cubes are exact. kappa must be above 1 + 3 sigma0.
  Morph(const Statue& statue, const std::array<double, 3>& eye, double kappa);

  // From the eye, in the maximum norm; 0 within the cube.
  double distance(const geometry::Point& p) const;
  double distance(const hierarchy::CubeId& cube) const;
  // Far enough to be drawn: nothing finer is needed.
  bool is_suitable(const hierarchy::CubeId& cube) const;
  // The share of the vertex's own position: exactly 1 up to the start of the band and at level 0, where the
  // vertex is to be drawn as it is; exactly 0 from its end on, where it is to be drawn as its parent.
  double lambda(const geometry::Point& vertex, int level) const;

  double kappa() const { return kappa_; }

 private:
  std::array<double, 3> eye_{};
  double kappa_ = 0.0;
  double sigma0_ = 0.0;
  int root_bits_ = 0;
};

struct Cut {
  std::vector<access::RowIndex> rows;  // drawn, ascending; with or without triangles
  std::optional<Morph> morph;          // none: vertices are drawn where they are
  std::string warning;                 // why the cut is not quite what was asked for; empty when it is
};

// All cubes of a level, unmorphed; beyond the deepest level those of the finest.
Cut cut_at_level(const Statue& statue, std::uint32_t level);

// The coarsest level all of whose nodes have an error of at most `error` (world units); else the finest, with
// a warning.
Cut cut_with_error(const Statue& statue, double error);

// The finest level with at most so many triangles, as stored; else level 0, with a warning.
Cut cut_with_triangles(const Statue& statue, std::uint64_t triangles);

// The least legal kappa: the next double above 1 + 3 sigma0.
double least_kappa(const Statue& statue);
// kDefaultKappa where that is legal, else the least legal one and a twentieth.
double default_kappa(const Statue& statue);

// From the root down, a cube is drawn when it is suitable, or when it is of the deepest level; its children
// are looked at else. Throws Error(kUsage) that tells the least legal value when kappa is less.
Cut cut_at_eye(const Statue& statue, const access::Eye& eye);

// How many cubes of each level the cut draws triangles of, from the root on.
std::vector<std::uint64_t> parts_by_level(const Statue& statue, const Cut& cut);

}  // namespace colossus::reader::blocks
