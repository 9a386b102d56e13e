#include "reader/input_samples.hpp"

#include <algorithm>
#include <cmath>

namespace colossus::reader {
namespace {

constexpr std::size_t kMostVertices = 2'000'000;

geometry::Point lattice_point(const geometry::Lattice& lattice, const WorldPoint& p) {
  geometry::Point q;
  for (std::size_t axis = 0; axis < 3; ++axis)
    q[static_cast<int>(axis)] = static_cast<std::int32_t>(std::clamp(
        std::floor((p[axis] - lattice.origin[axis]) / lattice.step), 0.0, double{geometry::kRootSide}));
  return q;
}

TetrahedronRef root_with(const Statue& statue, const geometry::Point& p) {
  const RowIndex row = statue.find(hierarchy::root_center());
  const hierarchy::Diamond root = hierarchy::Diamond::at(hierarchy::root_center());
  for (std::uint8_t place = 0; row != kNoRow && place < root.place_count; ++place)
    if (root.tetrahedra[place].contains(p)) return {row, place};
  return {};
}

}  // namespace

InputSamples sample_input(const Statue& statue, const Surface& surface, std::uint64_t seed) {
  InputSamples samples;
  const std::size_t stride = surface.points.size() / kMostVertices + 1;
  for (std::size_t i = 0; i < surface.points.size(); i += stride) samples.points.push_back(surface.points[i]);
  const auto spread = sample_surface(surface, samples.points.size(), seed);
  samples.points.insert(samples.points.end(), spread.begin(), spread.end());
  samples.by_row.resize(statue.rows().size());
  for (std::uint32_t i = 0; i < samples.points.size(); ++i) {
    const geometry::Point p = lattice_point(statue.lattice(), samples.points[i]);
    TetrahedronRef at = root_with(statue, p);
    hierarchy::Tetrahedron tetrahedron{};
    if (at.exists()) tetrahedron = hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[at.place];
    while (at.exists()) {
      samples.by_row[at.row].push_back(i);
      if (statue.is_leaf(at.row)) break;
      const int end = tetrahedron.bisector().side(p) >= 0 ? 0 : 1;
      at = statue.child(at, end);
      tetrahedron = tetrahedron.child(end);
    }
  }
  return samples;
}

}  // namespace colossus::reader
