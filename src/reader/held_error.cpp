#include "reader/held_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace colossus::reader {
namespace {

// Units of the builder's lattice of 2^30: half a cell of its input vertices on each axis is sqrt(3) * 4, each
// cut rounds by less than a unit, if not always in one direction, and far from the origin a sample's own
// coordinates are no finer than a cell.
constexpr double kRounding = 64.0;

// In lattice units; within the root cube, as everything that the container stands for.
WorldPoint lattice_position(const container::LatticeInfo& lattice, const WorldPoint& p) {
  WorldPoint q{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    q[axis] =
        std::clamp((p[axis] - lattice.origin[axis]) / lattice.step, 0.0, std::ldexp(1.0, lattice.root_bits));
  return q;
}

void consider(const StatueFile& statue, RowIndex row, const std::vector<bool>& is_damaged, HeldError& held) {
  if (is_damaged[row]) held.is_known = false;
  const double error = statue.rows()[row].error;
  if (held.row != kNoRow && !(error > held.error)) return;
  held.error = error;
  held.row = row;
}

double side(const geometry::Plane& plane, const WorldPoint& q) {
  return plane.normal[0] * q[0] + plane.normal[1] * q[1] + plane.normal[2] * q[2] -
         static_cast<double>(plane.offset);
}

struct Root {
  std::uint8_t place = 0;
  hierarchy::Tetrahedron tetrahedron;
  std::array<geometry::Plane, 4> faces;
};

std::vector<Root> all_roots() {
  const hierarchy::Diamond diamond = hierarchy::Diamond::at(hierarchy::root_center());
  std::vector<Root> roots;
  for (std::uint8_t place = 0; place < diamond.place_count; ++place) {
    Root root{place, diamond.tetrahedra[place], {}};
    for (int corner = 0; corner < 4; ++corner)
      root.faces[static_cast<std::size_t>(corner)] = root.tetrahedron.face_plane(corner);
    roots.push_back(root);
  }
  return roots;
}

// Walks down to the tetrahedra of a cut that come near a point.
class Descent {
 public:
  Descent(const Statue& statue, std::uint32_t level, const WorldPoint& q, const std::vector<bool>& is_damaged,
          bool counts_errors)
      : statue_(statue), level_(level), q_(q), is_damaged_(is_damaged), counts_errors_(counts_errors) {}

  HeldError run() {
    const RowIndex row = statue_.find(hierarchy::root_center());
    if (row == kNoRow) return held_;
    static const std::vector<Root> roots = all_roots();
    for (const Root& root : roots)
      if (std::all_of(root.faces.begin(), root.faces.end(),
                      [&](const geometry::Plane& face) { return side(face, q_) >= -reach(row); }))
        visit({row, root.place}, root.tetrahedron);
    return held_;
  }

 private:
  // As far as plane values tell, whose normals are up to sqrt(2) long.
  double reach(RowIndex row) const {
    const double error = counts_errors_ ? statue_.rows()[row].error / statue_.lattice().step : 0.0;
    return std::numbers::sqrt2 * (error + kRounding);
  }

  void visit(TetrahedronRef ref, const hierarchy::Tetrahedron& tetrahedron) {
    if (statue_.is_leaf(ref.row) || statue_.rows()[ref.row].level >= level_) {
      consider(statue_, ref.row, is_damaged_, held_);
      return;
    }
    const double at = side(tetrahedron.bisector(), q_);
    for (int end = 0; end < 2; ++end) {
      const TetrahedronRef half = statue_.child(ref, end);
      if (half.exists() && (end == 0 ? at : -at) >= -reach(half.row)) visit(half, tetrahedron.child(end));
    }
  }

  const Statue& statue_;
  const std::uint32_t level_;
  const WorldPoint& q_;
  const std::vector<bool>& is_damaged_;
  const bool counts_errors_;
  HeldError held_;
};

}  // namespace

HeldError held_error(const Statue& statue, std::uint32_t level, const WorldPoint& p,
                     const std::vector<bool>& is_damaged) {
  const WorldPoint q = lattice_position(statue.metadata().lattice, p);
  const HeldError held = Descent(statue, level, q, is_damaged, false).run();
  return held.row != kNoRow ? held : Descent(statue, level, q, is_damaged, true).run();
}

HeldError held_error(const CubeStatue& statue, std::uint32_t level, const WorldPoint& p,
                     const std::vector<bool>& is_damaged) {
  const WorldPoint q = lattice_position(statue.metadata().lattice, p);
  // No point of a triangle is farther from its barycentre than two thirds of its longest edge.
  const double reach = statue.longest_edge(static_cast<int>(statue.deepest_level())) * 2.0 / 3.0 + 1.0 +
                       std::ldexp(kRounding, statue.root_bits() - geometry::kRootBits);
  const double cubes = std::ldexp(1.0, static_cast<int>(level));
  const double cubes_per_unit = std::ldexp(cubes, -statue.root_bits());
  std::array<std::int32_t, 3> low{};
  std::array<std::int32_t, 3> high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto index = [&](double c) {
      return static_cast<std::int32_t>(std::clamp(std::floor(c * cubes_per_unit), 0.0, cubes - 1.0));
    };
    low[axis] = index(q[axis] - reach);
    high[axis] = index(q[axis] + reach);
  }
  HeldError held;
  for (std::int32_t x = low[0]; x <= high[0]; ++x)
    for (std::int32_t y = low[1]; y <= high[1]; ++y)
      for (std::int32_t z = low[2]; z <= high[2]; ++z)
        if (const RowIndex row = statue.find({static_cast<std::int32_t>(level), x, y, z}); row != kNoRow)
          consider(statue, row, is_damaged, held);
  return held;
}

}  // namespace colossus::reader
