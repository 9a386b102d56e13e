#include "verify/blocks/clefts.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"

namespace colossus::verify::blocks {
namespace {

constexpr double kLeastWidthsApart = 8.0;
constexpr std::uint64_t kLeastInterior = 20;  // triangles

// The borders of blocks of one level along one axis: multiples of a block's side, from the shift on.
struct Borders {
  double period = 0.0;
  double shift = 0.0;  // half a period, or nothing
  double root_side = 0.0;
  // From a coordinate to the nearest border within the root cube.
  bool has_within(double coordinate, double width) const {
    const double nearest = std::floor((coordinate - shift) / period + 0.5) * period + shift;
    return nearest > 0.0 && nearest < root_side && std::abs(coordinate - nearest) <= width;
  }
};

bool is_near(const Borders& borders, const geometry::Vec3& p, double width) {
  return borders.has_within(p.x, width) || borders.has_within(p.y, width) || borders.has_within(p.z, width);
}

}  // namespace

void CleftCounts::add(const CleftCounts& other) {
  for (std::size_t zone = 0; zone < triangles.size(); ++zone) {
    triangles[zone] += other.triangles[zone];
    expected[zone] += other.expected[zone];
  }
}

measure::CleftDensities CleftCounts::densities() const {
  const auto relative = [&](Zone zone) -> std::optional<double> {
    if (!(expected[zone] > 0.0) || triangles[zone] == 0) return std::nullopt;
    return static_cast<double>(triangles[zone]) / expected[zone];
  };
  return {relative(kLocked), relative(kEarlier)};
}

CleftCounts count_clefts(const reader::blocks::Statue& statue, int level, const codec::coded::CodedNode& node,
                         double width, bool has_shifted_blocks) {
  std::vector<Borders> borders;  // of levels level + 1, level + 2 ...
  const double root_side = std::ldexp(1.0, statue.root_bits());
  for (int finer = level + 1; finer <= static_cast<int>(statue.deepest_level()); ++finer) {
    const double period = std::ldexp(static_cast<double>(statue.block_size()), statue.root_bits() - finer);
    if (period < kLeastWidthsApart * width) break;
    borders.push_back({period, has_shifted_blocks ? period / 2.0 : 0.0, root_side});
  }
  constexpr std::size_t kInterior = 2;
  std::array<std::uint64_t, 3> triangles{};
  std::array<double, 3> areas{};
  for (const mesh::Triangle& t : node.parts[0].triangles) {
    const geometry::Vec3 a = geometry::to_vec3(lattice_position(node, t[0]));
    const geometry::Vec3 b = geometry::to_vec3(lattice_position(node, t[1]));
    const geometry::Vec3 c = geometry::to_vec3(lattice_position(node, t[2]));
    const geometry::Vec3 barycenter = (1.0 / 3.0) * (a + b + c);
    std::size_t zone = kInterior;
    for (std::size_t i = borders.size(); i-- > 0;)
      if (is_near(borders[i], barycenter, width))
        zone = i == 0 ? CleftCounts::kLocked : CleftCounts::kEarlier;
    ++triangles[zone];
    areas[zone] += 0.5 * geometry::length(geometry::cross(b - a, c - a));
  }
  CleftCounts counts;
  if (triangles[kInterior] < kLeastInterior || !(areas[kInterior] > 0.0)) return counts;
  for (const std::size_t zone : {CleftCounts::kLocked, CleftCounts::kEarlier}) {
    counts.triangles[zone] = triangles[zone];
    counts.expected[zone] = areas[zone] / areas[kInterior] * static_cast<double>(triangles[kInterior]);
  }
  return counts;
}

EdgeLengths edge_lengths(const codec::coded::CodedNode& node) {
  EdgeLengths lengths;
  for (const mesh::Triangle& t : node.parts[0].triangles)
    for (std::size_t k = 0; k < 3; ++k)
      lengths.sum += std::sqrt(static_cast<double>(
          geometry::squared_distance(lattice_position(node, t[k]), lattice_position(node, t[(k + 1) % 3]))));
  lengths.count = node.parts[0].triangles.size() * 3;
  return lengths;
}

}  // namespace colossus::verify::blocks
