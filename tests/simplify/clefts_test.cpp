// Density along borders that are locked, and along those that will be.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "simplify/collapse.hpp"
#include "simplify/mesh_checks.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

constexpr std::uint64_t kSeeds = 4;
constexpr std::uint32_t kSide = 48;

Vec3 barycenter(const Mesh& mesh, const Triangle& t) {
  return (1.0 / 3.0) * (at(mesh, t[0]) + at(mesh, t[1]) + at(mesh, t[2]));
}

// A sheet of two halves: the cells are 0 and 1.
Region two_halves(std::uint64_t seed) {
  Region region = make_region(rough_sheet(kSide, kSide, 0.05, seed), {}, {});
  region.may_place = false;
  for (std::size_t i = 0; i < region.cells.size(); ++i)
    region.cells[i] = barycenter(region.mesh, region.mesh.triangles[i]).x < kMiddle ? 0 : 1;
  return region;
}

// Edges of both halves.
std::size_t count_between(const Region& region) {
  std::array<std::vector<Triangle>, 2> halves;
  for (std::size_t i = 0; i < region.cells.size(); ++i)
    halves[region.cells[i]].push_back(region.mesh.triangles[i]);
  return mesh::edges(halves[0]).size() + mesh::edges(halves[1]).size() -
         mesh::edges(region.mesh.triangles).size();
}

Region simplified(Region region, const std::vector<std::uint16_t>& next_regions) {
  region.next_regions = next_regions;
  simplify(region, region.mesh.triangles.size() / 4);
  return region;
}

TEST(Clefts, BordersToComeAreThinnedOutAhead) {
  std::size_t known = 0, unknown = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Region region = two_halves(seed);
    known += count_between(simplified(region, {0, 1}));
    const Region plain = simplified(region, {});
    unknown += count_between(plain);
    // What stays together is like the rest.
    EXPECT_EQ(simplified(region, {3, 3}).mesh.triangles, plain.mesh.triangles);
  }
  EXPECT_LT(known * 3, unknown * 2) << known << ' ' << unknown;
}

TEST(Clefts, FewTrianglesAreLeftAtLockedVertices) {
  double near_count = 0.0, near_area = 0.0, far_count = 0.0, far_area = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Region region = two_halves(seed);
    region.outer_faces = 1;
    std::vector<int> cells_of(region.mesh.vertices.size(), 0);
    for (std::size_t i = 0; i < region.cells.size(); ++i)
      for (const auto v : region.mesh.triangles[i]) cells_of[v] |= 1 << region.cells[i];
    for (std::size_t v = 0; v < cells_of.size(); ++v) region.faces[v] = cells_of[v] == 3 ? 1 : 0;
    region = simplified(region, {});
    // Of an equilateral triangle of mean area.
    const double edge =
        std::sqrt(2.3 / static_cast<double>(region.mesh.triangles.size())) * 0.8 * geometry::kRootSide;
    for (const Triangle& t : region.mesh.triangles) {
      const double area = geometry::length(geometry::cross(at(region.mesh, t[1]) - at(region.mesh, t[0]),
                                                           at(region.mesh, t[2]) - at(region.mesh, t[0])));
      const bool is_near = std::abs(barycenter(region.mesh, t).x - kMiddle) < edge;
      (is_near ? near_count : far_count) += 1.0;
      (is_near ? near_area : far_area) += area;
    }
  }
  const double ratio = near_count / near_area / (far_count / far_area);
  EXPECT_LT(ratio, 1.5);  // 1.56 if collapses onto locked vertices cost what they harm
}

}  // namespace
}  // namespace colossus::simplify
