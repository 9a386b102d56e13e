// Colours in the error of half-edge collapses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "simplify/collapse.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

constexpr std::uint64_t kSeeds = 4;

// Flat, red on one side of a slanted line and blue on the other.
Region painted_sheet(std::uint64_t seed) {
  Mesh sheet = rough_sheet(40, 40, 0.0, seed);
  for (mesh::Vertex& vertex : sheet.vertices) {
    const Vec3 p = geometry::to_vec3(vertex.position) - kCenter;
    vertex.color = p.x > 0.3 * p.y ? mesh::Color{220, 30, 30, 255} : mesh::Color{20, 40, 200, 255};
  }
  Region region = make_region(sheet, {}, {});
  region.may_place = false;
  return region;
}

// Of the triangle of the flat mesh over p, or the one that p is least outside of.
Vec3 color_at(const Mesh& mesh, const Vec3& p) {
  const auto doubled_area = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  };
  double most_inside = -std::numeric_limits<double>::max();
  Vec3 found;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = at(mesh, t[0]), b = at(mesh, t[1]), c = at(mesh, t[2]);
    const double whole = doubled_area(a, b, c);
    const std::array<double, 3> shares{doubled_area(b, c, p) / whole, doubled_area(c, a, p) / whole,
                                       doubled_area(a, b, p) / whole};
    const double least = *std::min_element(shares.begin(), shares.end());
    if (least <= most_inside) continue;
    most_inside = least;
    double sum = 0.0;
    for (const double share : shares) sum += std::max(share, 0.0);
    found = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const mesh::Color& color = mesh.vertices[t[k]].color;
      found = found +
              (std::max(shares[k], 0.0) / sum) * Vec3{double(color[0]), double(color[1]), double(color[2])};
    }
  }
  return found;
}

// Root mean square over the vertices before, in steps of a channel.
double color_error(const Mesh& before, const Mesh& after) {
  double sum = 0.0;
  for (const mesh::Vertex& vertex : before.vertices) {
    const Vec3 color{double(vertex.color[0]), double(vertex.color[1]), double(vertex.color[2])};
    sum += geometry::squared_length(color_at(after, geometry::to_vec3(vertex.position)) - color);
  }
  return std::sqrt(sum / static_cast<double>(before.vertices.size()));
}

TEST(SimplifyColors, KeepAnEdgeThatIsPaintedOnAFlatSheet) {
  double plain_sum = 0.0;
  double weighed_sum = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Region before = painted_sheet(seed);
    const std::size_t target = before.mesh.triangles.size() / 4;
    Region plain = before;
    const Outcome plain_outcome = simplify(plain, target);
    Region weighed = before;
    weighed.color_weight = 1.0;
    const Outcome weighed_outcome = simplify(weighed, target);
    EXPECT_EQ(weighed_outcome.final_triangles, plain_outcome.final_triangles);
    const double plain_error = color_error(before.mesh, plain.mesh);
    const double weighed_error = color_error(before.mesh, weighed.mesh);
    EXPECT_LT(4.0 * weighed_error, plain_error);
    plain_sum += plain_error;
    weighed_sum += weighed_error;
  }
  std::printf("colour error %.2f without weight, %.2f with\n", plain_sum / kSeeds, weighed_sum / kSeeds);
}

TEST(SimplifyColors, OfNoWeightChangeNothing) {
  Region painted = painted_sheet(1);
  Region white = painted;
  for (mesh::Vertex& vertex : white.mesh.vertices) vertex.color = {255, 255, 255, 255};
  simplify(painted, 500);
  simplify(white, 500);
  EXPECT_EQ(painted.mesh.triangles, white.mesh.triangles);
}

TEST(SimplifyColors, ScaleWithTheMesh) {
  // Eight times smaller: the same edges in the same order, as the weight follows the mean edge length. In
  // whole steps of eight, so that both sheets are the same but for their size.
  Region large = painted_sheet(2);
  Region small = large;
  for (std::size_t v = 0; v < large.mesh.vertices.size(); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      small.mesh.vertices[v].position[axis] = large.mesh.vertices[v].position[axis] / 8;
      large.mesh.vertices[v].position[axis] = small.mesh.vertices[v].position[axis] * 8;
    }
  large.color_weight = small.color_weight = 2.0;
  large.samples.clear();
  small.samples.clear();
  simplify(large, 500);
  simplify(small, 500);
  EXPECT_EQ(large.mesh.triangles, small.mesh.triangles);
}

TEST(SimplifyColorsDeathTest, NeedHalfEdgeCollapses) {
  Region region = painted_sheet(0);
  region.may_place = true;
  region.color_weight = 1.0;
  EXPECT_DEATH(simplify(region, 100), "half-edge");
  region.may_place = false;
  region.color_weight = -1.0;
  EXPECT_DEATH(simplify(region, 100), "colours");
}

}  // namespace
}  // namespace colossus::simplify
