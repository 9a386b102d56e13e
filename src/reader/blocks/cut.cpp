#include "reader/blocks/cut.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"

namespace colossus::reader::blocks {
namespace {

// Coordinates up to 2^32 with this many binary places are exact doubles, and so are their differences.
constexpr int kEyeBits = 20;
constexpr double kExactReach = 4294967296.0;

Cut level_cut(const Statue& statue, std::uint32_t level) {
  const access::RowRange range = statue.rows_of_level(level);
  Cut cut;
  cut.rows.resize(range.size());
  std::iota(cut.rows.begin(), cut.rows.end(), range.first);
  return cut;
}

double snapped(double lattice_coordinate) {
  if (!(std::abs(lattice_coordinate) < kExactReach)) return std::nearbyint(lattice_coordinate);
  return std::ldexp(std::nearbyint(std::ldexp(lattice_coordinate, kEyeBits)), -kEyeBits);
}

}  // namespace

Morph::Morph(const Statue& statue, const std::array<double, 3>& eye, double kappa)
    : kappa_(kappa), sigma0_(statue.sigma0()), root_bits_(statue.root_bits()) {
  const container::LatticeInfo& lattice = statue.metadata().lattice;
  for (std::size_t axis = 0; axis < 3; ++axis)
    eye_[axis] = snapped((eye[axis] - lattice.origin[axis]) / lattice.step);
}

double Morph::distance(const geometry::Point& p) const {
  double distance = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    distance = std::max(distance, std::abs(eye_[static_cast<std::size_t>(axis)] - p[axis]));
  return distance;
}

double Morph::distance(const hierarchy::CubeId& cube) const {
  const geometry::Point low = cube.corner(root_bits_);
  const auto side = static_cast<double>(cube.side(root_bits_));
  double distance = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double c = eye_[static_cast<std::size_t>(axis)];
    distance = std::max({distance, low[axis] - c, c - low[axis] - side});
  }
  return distance;
}

bool Morph::is_suitable(const hierarchy::CubeId& cube) const {
  return distance(cube) >= std::ldexp(kappa_, root_bits_ - cube.level);
}

double Morph::lambda(const geometry::Point& vertex, int level) const {
  if (level == 0) return 1.0;
  const double start = std::ldexp(1.0 + kappa_ + sigma0_, root_bits_ - level);
  const double end = std::ldexp(kappa_ - sigma0_, root_bits_ - level + 1);
  const double d = distance(vertex);
  if (d <= start) return 1.0;
  if (d >= end) return 0.0;
  return (end - d) / (end - start);
}

Cut cut_at_level(const Statue& statue, std::uint32_t level) {
  return level_cut(statue, std::min(level, statue.deepest_level()));
}

Cut cut_with_error(const Statue& statue, double error) {
  double greatest = 0.0;
  for (std::uint32_t level = 0; level <= statue.deepest_level(); ++level) {
    greatest = 0.0;
    const access::RowRange range = statue.rows_of_level(level);
    for (access::RowIndex row = range.first; row < range.last; ++row)
      greatest = std::max(greatest, statue.rows()[row].error);
    if (range.size() > 0 && greatest <= error) return level_cut(statue, level);
  }
  Cut cut = level_cut(statue, statue.deepest_level());
  cut.warning = fmt::format("the finest level has errors above {}, up to {}", error, greatest);
  return cut;
}

Cut cut_with_triangles(const Statue& statue, std::uint64_t triangles) {
  std::uint64_t coarsest = 0;
  for (std::uint32_t level = statue.deepest_level() + 1; level-- > 0;) {
    coarsest = 0;
    const access::RowRange range = statue.rows_of_level(level);
    for (access::RowIndex row = range.first; row < range.last; ++row)
      coarsest += statue.rows()[row].triangles;
    if (range.size() > 0 && coarsest <= triangles) return level_cut(statue, level);
  }
  Cut cut = level_cut(statue, 0);
  cut.warning =
      fmt::format("the root, the coarsest level, has {} triangles, more than {}", coarsest, triangles);
  return cut;
}

double least_kappa(const Statue& statue) {
  return std::nextafter(1.0 + 3.0 * statue.sigma0(), std::numeric_limits<double>::infinity());
}

double default_kappa(const Statue& statue) {
  const double least = least_kappa(statue);
  return access::kDefaultKappa >= least ? access::kDefaultKappa : least * 1.05;
}

Cut cut_at_eye(const Statue& statue, const access::Eye& eye) {
  const double kappa = eye.kappa.value_or(default_kappa(statue));
  if (!(kappa >= least_kappa(statue)) || !std::isfinite(kappa))
    core::fail(core::Status::kUsage,
               "kappa: expected more than 1 + 3 sigma0, that is at least {} for this container, found {}",
               least_kappa(statue), kappa);
  for (const double c : eye.position)
    if (!std::isfinite(c)) core::fail(core::Status::kUsage, "eye: expected finite coordinates, found {}", c);
  Cut cut;
  cut.morph.emplace(statue, eye.position, kappa);
  const int deepest = static_cast<int>(statue.deepest_level());
  std::vector<access::RowIndex> pending;
  if (const access::RowIndex root = statue.find({}); root != access::kNoRow) pending.push_back(root);
  while (!pending.empty()) {
    const access::RowIndex row = pending.back();
    pending.pop_back();
    const hierarchy::CubeId cube = statue.cube(row);
    if (cube.level == deepest || cut.morph->is_suitable(cube)) {
      cut.rows.push_back(row);
      continue;
    }
    for (const access::RowIndex child : statue.children(row))
      if (child != access::kNoRow) pending.push_back(child);
  }
  std::sort(cut.rows.begin(), cut.rows.end());
  return cut;
}

std::vector<std::uint64_t> parts_by_level(const Statue& statue, const Cut& cut) {
  std::vector<std::uint64_t> counts(statue.deepest_level() + 1, 0);
  for (const access::RowIndex row : cut.rows)
    if (const container::NodeRow& node = statue.rows()[row]; node.triangles > 0) ++counts[node.level];
  return counts;
}

}  // namespace colossus::reader::blocks
