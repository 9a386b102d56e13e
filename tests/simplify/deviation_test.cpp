#include "simplify/deviation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "mesh/adjacency.hpp"
#include "simplify/brute_force.hpp"
#include "simplify/collapse.hpp"
#include "simplify/region_fixtures.hpp"

namespace colossus::simplify {
namespace {

void expect_samples_measured(const Region& region, const Outcome& outcome) {
  const BruteForce surface(region.mesh);
  mesh::Adjacency adjacency;
  adjacency.build(region.mesh.triangles, region.mesh.vertices.size());
  double farthest = 0.0;
  double truly_farthest = 0.0;
  for (const SurfaceSample& sample : region.samples) {
    const Vec3 p = geometry::to_vec3(sample.position);
    const double truth = surface.distance(p);
    const double said = static_cast<double>(sample.distance);
    // Rounding may lose what is below 1e-7 of a triangle.
    ASSERT_GE(said, truth * (1.0 - 1e-6) - 1e-8 * kRadius);
    farthest = std::max(farthest, said);
    truly_farthest = std::max(truly_farthest, truth);
    ASSERT_LT(sample.anchor, region.mesh.vertices.size());
    bool is_attached = false;
    for (const auto i : adjacency.around(sample.anchor)) {
      const Triangle& t = region.mesh.triangles[i];
      const double d =
          distance_to_triangle(p, at(region.mesh, t[0]), at(region.mesh, t[1]), at(region.mesh, t[2]));
      is_attached |= region.cells[i] == sample.cell && d <= said * (1.0 + 1e-6) + 1e-8 * kRadius;
    }
    ASSERT_TRUE(is_attached);
  }
  EXPECT_GT(truly_farthest, 0.0);
  EXPECT_GE(outcome.deviation, farthest);
  // Measured, not added up.
  EXPECT_LT(outcome.deviation, 4.0 * truly_farthest);
}

TEST(Deviation, IsNeverLessThanTheDistanceOfAnySample) {
  for (const bool has_border : {false, true}) {
    const Mesh original = has_border ? wavy_grid(40) : sphere(4, 0.005, 7);
    Region region = make_region(original, kInnerPlanes, {});
    const std::size_t sample_count = region.samples.size();
    // Samples of the input are carried along.
    for (int round = 0; round < 3; ++round) {
      SCOPED_TRACE(testing::Message() << "has_border " << has_border << ", round " << round);
      const Outcome outcome = simplify(region, region.mesh.triangles.size() / 2);
      EXPECT_EQ(region.samples.size(), sample_count);
      expect_samples_measured(region, outcome);
    }
  }
}

// A square of 800 around a middle vertex, its corners first.
Mesh pyramid(std::int32_t height) {
  Mesh mesh;
  for (const Point& p : {Point{0, 0, 0}, {800, 0, 0}, {800, 800, 0}, {0, 800, 0}, {400, 400, height}})
    mesh.vertices.push_back(vertex_at(p));
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

TEST(Deviation, AddsTheDistanceOfAPlacedVertexToWhatTheSamplesThereSaid) {
  const std::vector<std::uint16_t> cells(4, 0);
  const std::vector<std::uint32_t> same{0, 1, 2, 3, 4};
  std::vector<SurfaceSample> samples{{{400, 400, 30}, 4, 30.0F, 0}, {{0, 0, 0}, 0, 0.0F, 0}};
  const Deviation deviation = measure_deviation(pyramid(0), pyramid(100), cells, same, false, samples);
  EXPECT_FLOAT_EQ(static_cast<float>(deviation.of_surface), 130.0F);
  EXPECT_EQ(deviation.of_samples, samples[0].distance);
  // To the slope of 1 in 4 from 70 below its top.
  EXPECT_FLOAT_EQ(samples[0].distance, 70.0F * 4.0F / std::sqrt(17.0F));
  EXPECT_EQ(samples[1].distance, 0.0F);
  EXPECT_EQ(deviation.estimate(), 1.5 * deviation.of_surface);

  samples = {{{400, 400, 300}, 4, 0.0F, 0}};
  const Deviation of_sample = measure_deviation(pyramid(0), pyramid(100), cells, same, false, samples);
  EXPECT_FLOAT_EQ(static_cast<float>(of_sample.of_samples), 200.0F);
  EXPECT_EQ(of_sample.estimate(), 1.5 * of_sample.of_samples);
}

TEST(Deviation, MeasuresABorderThatHasGrownOverANotch) {
  Mesh before;
  for (const Point& p : {Point{0, 0, 0}, {800, 0, 0}, {800, 800, 0}, {0, 800, 0}, {400, 300, 0}})
    before.vertices.push_back(vertex_at(p));
  Mesh after = before;
  before.triangles = {{0, 4, 3}, {4, 2, 3}, {4, 1, 2}};
  after.vertices.pop_back();
  after.triangles = {{0, 2, 3}, {0, 1, 2}};
  const std::vector<std::uint16_t> cells(2, 0);
  const std::vector<std::uint32_t> collapsed{0, 1, 2, 3, 0};
  std::vector<SurfaceSample> samples{{{400, 300, 7}, 4, 7.0F, 0}};
  // The middle of the new edge is 400 * 3 / 5 from the notch's sides.
  EXPECT_FLOAT_EQ(
      static_cast<float>(measure_deviation(before, after, cells, collapsed, true, samples).of_surface),
      247.0F);
  EXPECT_EQ(samples[0].distance, 7.0F);
}

TEST(Deviation, FindsASheetThatNoWalkReaches) {
  Mesh sheets = pyramid(0);
  Mesh upper = pyramid(0);
  for (mesh::Vertex& vertex : upper.vertices) vertex.position.z = 900;
  append(sheets, upper);
  const std::vector<std::uint16_t> cells{0, 0, 0, 0, 1, 1, 1, 1};
  std::vector<std::uint32_t> same(sheets.vertices.size());
  std::iota(same.begin(), same.end(), 0U);
  std::vector<SurfaceSample> samples{{{700, 60, 1000}, 4, 0.0F, 0}};
  const Deviation deviation = measure_deviation(sheets, sheets, cells, same, true, samples);
  EXPECT_EQ(deviation.of_samples, 100.0);
  EXPECT_EQ(samples[0].distance, 100.0F);
  EXPECT_EQ(samples[0].anchor, 6U);  // the nearest corner
  EXPECT_EQ(samples[0].cell, 1U);
}

TEST(Deviation, IsExactForTheFarthestSampleWhereverItIsAnchored) {
  Mesh sheets;
  for (const std::int32_t shift : {0, -kMiddle / 2, kMiddle / 3}) {
    Mesh sheet = wavy_grid(20);
    for (mesh::Vertex& vertex : sheet.vertices) vertex.position.z += shift;
    append(sheets, sheet);
  }
  const BruteForce surface(sheets);
  const std::vector<std::uint16_t> cells(sheets.triangles.size(), 0);
  std::vector<std::uint32_t> same(sheets.vertices.size());
  std::iota(same.begin(), same.end(), 0U);
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto coordinate = [&] { return static_cast<std::int32_t>(random() % geometry::kRootSide); };
    const Point p{coordinate(), coordinate(), coordinate()};
    std::vector<SurfaceSample> samples{
        {p, static_cast<std::uint32_t>(random() % sheets.vertices.size()), 0.0F, 0}};
    const double truth = surface.distance(geometry::to_vec3(p));
    EXPECT_NEAR(measure_deviation(sheets, sheets, cells, same, true, samples).of_samples, truth,
                1e-6 * truth);
  }
}

TEST(Deviation, ThinningOutKeepsTheFarthestInWhateverOrder) {
  constexpr std::uint64_t kSeed = 8;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::vector<SurfaceSample> samples;
  for (std::int32_t i = 0; i < 1000; ++i)
    samples.push_back({{i, static_cast<std::int32_t>(random() % 1000), 0},
                       static_cast<std::uint32_t>(random() % 50),
                       static_cast<float>(random() % 300),
                       0});
  std::vector<float> distances;
  for (const SurfaceSample& sample : samples) distances.push_back(sample.distance);
  std::sort(distances.begin(), distances.end(), std::greater<>());
  std::vector<SurfaceSample> shuffled = samples;
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  thin_out(samples, 200);
  thin_out(shuffled, 200);
  ASSERT_EQ(samples.size(), 200U);
  ASSERT_EQ(shuffled.size(), 200U);
  std::vector<float> left;
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_EQ(samples[i].position, shuffled[i].position);
    left.push_back(samples[i].distance);
    EXPECT_LE(samples[i == 0 ? 0 : i - 1].anchor, samples[i].anchor);
  }
  std::sort(left.begin(), left.end(), std::greater<>());
  EXPECT_TRUE(std::equal(left.begin(), left.begin() + 50, distances.begin()));
  EXPECT_LT(left.back(), distances[200]);  // others are not chosen by distance
  thin_out(samples, 500);
  EXPECT_EQ(samples.size(), 200U);
}

}  // namespace
}  // namespace colossus::simplify
