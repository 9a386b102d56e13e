// How far the input reaches, and corners that lie far from the rest.
#include "pipeline/ingest/extent.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pipeline/test_build.hpp"

namespace colossus::pipeline::ingest {
namespace {

using Position = std::array<double, 3>;

// A strip of triangles through random points of a ball.
MadeUpFile strip(std::size_t count, double radius, std::mt19937_64& random) {
  std::uniform_real_distribution<double> coordinate(-radius, radius);
  MadeUpFile file;
  for (std::uint32_t v = 0; v < count; ++v) {
    file.positions.push_back({coordinate(random), coordinate(random), coordinate(random)});
    if (v >= 2) file.triangles.push_back({v - 2, v - 1, v});
  }
  return file;
}

struct Measured {
  facts::Catalog catalog;
  std::optional<core::Error> error;
};

// The extent, and where there is a far corner the median edge.
Measured measure(const std::vector<MadeUpFile>& files) {
  const CommonFolder folder;
  const TestBuild build(folder);
  Measured measured{store_files(build.workspace(), files, 20'000, 20'000), {}};
  facts::Catalog& catalog = measured.catalog;
  std::vector<TriangleGroup> groups = request_vertices(build.workspace(), catalog);
  measured.error = error_of([&] { measure_extent(build.workspace(), catalog, groups); });
  if (measured.error || !(catalog.bounds.extent() > 0.0)) return measured;
  catalog.lattice = geometry::Lattice::fit(catalog.bounds);
  answer_requests(build.workspace(), catalog, groups);
  measure_median_edge(build.workspace(), catalog, groups);
  return measured;
}

TEST(Extent, IsThatOfTheVerticesThatTrianglesUse) {
  std::mt19937_64 random(test_seed());
  std::vector<MadeUpFile> files{strip(150'000, 3.0, random), strip(50'000, 2.0, random)};
  geometry::Bounds expected;
  for (const MadeUpFile& file : files)
    for (const Position& p : file.positions) expected.add(p);
  // Nobody uses these.
  files[0].positions.push_back({1e300, 0.0, 0.0});
  files[1].positions.push_back({std::nan(""), 0.0, 0.0});
  const Measured measured = measure(files);
  EXPECT_FALSE(measured.error);
  EXPECT_EQ(measured.catalog.bounds.low, expected.low);
  EXPECT_EQ(measured.catalog.bounds.high, expected.high);
  EXPECT_FALSE(measured.catalog.far_corner.is_far);
  EXPECT_EQ(far_corner_text(measured.catalog), "");
  EXPECT_NO_THROW(refuse_far_corner({}, measured.catalog, 1e300));
}

TEST(Extent, HasNoNegativeZeros) {
  MadeUpFile file;
  file.positions = {{-0.0, -0.0, 0.0}, {0.0, 1.0, -0.0}, {1.0, 0.0, -0.0}};
  file.triangles = {{0, 1, 2}};
  const Measured measured = measure({file});
  for (const double c : measured.catalog.bounds.low) EXPECT_FALSE(std::signbit(c));
  for (const double c : measured.catalog.bounds.high) EXPECT_FALSE(std::signbit(c));
}

TEST(Extent, OfCoordinatesThatAreNoNumbersIsBadDataOfThatVertex) {
  std::mt19937_64 random(test_seed());
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    std::vector<MadeUpFile> files{strip(100, 1.0, random), strip(1000, 1.0, random)};
    files[1].positions[777][1] = bad;
    const Measured measured = measure(files);
    ASSERT_ALL(measured.error.has_value());
    EXPECT_EQ(measured.error->status(), core::Status::kBadData);
    EXPECT_NE(std::string(measured.error->what()).find("made-up-1.ply"), std::string::npos)
        << measured.error->what();
    EXPECT_NE(std::string(measured.error->what()).find("777"), std::string::npos) << measured.error->what();
  }
}

TEST(Extent, OfCoordinatesWhoseDifferencesOverflowIsBadData) {
  std::mt19937_64 random(test_seed());
  MadeUpFile file = strip(100, 1.0, random);
  file.positions[5][2] = -1.5e308;
  const Measured measured = measure({file});
  ASSERT_ALL(measured.error.has_value());
  EXPECT_EQ(measured.error->status(), core::Status::kBadData);
  EXPECT_NE(std::string(measured.error->what()).find("coordinate z ranges from"), std::string::npos);
}

TEST(FarCorner, IsTheFarthestOfTheFewThatMakeTheLatticeCoarse) {
  std::mt19937_64 random(test_seed());
  for (const double far : {20.0, 1e6, 1e100}) {
    std::vector<MadeUpFile> files{strip(3000, 1.0, random), strip(200'000, 1.0, random)};
    files[1].positions[12'345] = {far, 2.0, 3.0};
    files[1].positions[150'000] = {0.0, 0.99 * far, 0.0};
    const Measured measured = measure(files);
    ASSERT_ALL(!measured.error);
    const facts::FarCorner& corner = measured.catalog.far_corner;
    ASSERT_ALL(corner.is_far);
    EXPECT_EQ(corner.file, 1U);
    EXPECT_EQ(corner.vertex, 12'345U);
    EXPECT_EQ(corner.position, files[1].positions[12'345]);
    EXPECT_LE(corner.core.extent(), 2.0);
    EXPECT_GT(corner.core.extent(), 1.9);
    EXPECT_NE(far_corner_text(measured.catalog).find("vertex 12345"), std::string::npos);
  }
}

TEST(FarCorner, IsNoneWhereSeveralPartsLieApartOrVerticesAreFew) {
  std::mt19937_64 random(test_seed());
  std::vector<MadeUpFile> apart{strip(3000, 1.0, random), strip(3000, 1.0, random)};
  for (Position& p : apart[1].positions) p[0] += 1000.0;
  EXPECT_FALSE(measure(apart).catalog.far_corner.is_far);
  MadeUpFile few = strip(15, 1.0, random);
  few.positions[0][0] = 1e6;
  EXPECT_FALSE(measure({few}).catalog.far_corner.is_far);
  MadeUpFile near = strip(3000, 1.0, random);
  near.positions[0][0] = 5.0;
  EXPECT_FALSE(measure({near}).catalog.far_corner.is_far);
  MadeUpFile point = strip(3000, 0.0, random);
  EXPECT_FALSE(measure({point}).catalog.far_corner.is_far);
}

// A grid whose edges have lengths 1, 1 and the root of 2.
TEST(FarCorner, CostsTrianglesFromTheMedianEdgeOn) {
  MadeUpFile file;
  for (std::uint32_t y = 0; y < 200; ++y)
    for (std::uint32_t x = 0; x < 200; ++x) {
      file.positions.push_back({1.0 * x, 1.0 * y, 0.0});
      const std::uint32_t v = 200 * y + x;
      if (x > 0 && y > 0) {
        file.triangles.push_back({v, v - 1, v - 201});
        file.triangles.push_back({v, v - 201, v - 200});
      }
    }
  file.positions[0] = {-1e7, 0.0, 0.0};
  const Measured measured = measure({file});
  ASSERT_ALL(measured.catalog.far_corner.is_far);
  const double edge = measured.catalog.far_corner.median_edge;
  EXPECT_NEAR(edge, 1.0, 0.15);
  EXPECT_NO_THROW(refuse_far_corner({}, measured.catalog, edge));
  const auto error = error_of([&] { refuse_far_corner({}, measured.catalog, 1.01 * edge); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->status(), core::Status::kBadData);
  EXPECT_NE(std::string(error->what()).find("--keep-outliers"), std::string::npos);
  facts::BuildOptions options;
  options.keep_outliers = true;
  EXPECT_NO_THROW(refuse_far_corner(options, measured.catalog, 1.01 * edge));
}

}  // namespace
}  // namespace colossus::pipeline::ingest
