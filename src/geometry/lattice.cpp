#include "geometry/lattice.hpp"

#include <cmath>

#include "core/error.hpp"

namespace colossus::geometry {
namespace {

// Cells of kInputSpacing units along the root cube.
constexpr int kCellBits = kRootBits - 3;
constexpr double kCells = static_cast<double>(std::int64_t{1} << kCellBits);

// The bounds fill at most this share of the cube, and their centre lies off the cube's centre by these
// shares: planes of symmetry, and faces of boxes at halves and quarters of the bounds, would else lie within
// a unit of planes of the hierarchy, where quantisation makes everything fall together.
constexpr double kMostFilled = 0.9;
constexpr std::array<double, 3> kShift{0.0271, 0.0167, 0.0353};

}  // namespace

Lattice Lattice::fit(const Bounds& bounds) {
  COLOSSUS_CHECK(!bounds.is_empty());
  double extent = 0.0;
  double magnitude = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent = std::max(extent, bounds.high[axis] - bounds.low[axis]);
    magnitude = std::max({magnitude, std::abs(bounds.low[axis]), std::abs(bounds.high[axis])});
  }
  // Nothing is gained below the spacing of the input's doubles; the least exponent is for a mesh of one
  // point.
  int exponent = -1000;
  if (extent > 0.0)
    exponent = std::max(exponent, static_cast<int>(std::ceil(std::log2(extent / (kCells * kMostFilled)))));
  while (std::ldexp(kCells * kMostFilled, exponent) < extent) ++exponent;
  if (magnitude > 0.0) exponent = std::max(exponent, std::ilogb(magnitude) - 52);
  const double cell = std::ldexp(1.0, exponent);
  Lattice lattice;
  lattice.step = cell / kInputSpacing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double center = bounds.low[axis] + (bounds.high[axis] - bounds.low[axis]) / 2.0;
    const double base = std::floor(center / cell) * cell - std::floor(kCells * (0.5 + kShift[axis])) * cell;
    lattice.origin[axis] = base - lattice.step * kInputResidue[axis];
  }
  return lattice;
}

Point Lattice::input_vertex(const std::array<double, 3>& world) const {
  Point p;
  const double cell = step * kInputSpacing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double base = origin[axis] + step * kInputResidue[axis];
    const double index = std::floor((world[axis] - base) / cell + 0.5);
    COLOSSUS_CHECK(index >= 1.0 && index < kCells, "vertex outside the lattice: {}", index);
    p[static_cast<int>(axis)] = static_cast<std::int32_t>(index) * kInputSpacing + kInputResidue[axis];
  }
  return p;
}

double Lattice::input_error() const { return std::sqrt(3.0) / 2.0 * step * kInputSpacing; }

}  // namespace colossus::geometry
