// Each group of triangles gets the vertices that it uses, by way of scratch: as if they had been looked up.
#include "pipeline/ingest/join.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "pipeline/facts/fingerprint.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::ingest {
namespace {

// What is random about a file.
struct Kind {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  bool has_normals = false;
  bool has_colors = false;
  bool has_byte_colors = false;
  bool has_face_colors = false;
  bool is_local = false;  // triangles name vertices near each other
};

MadeUpFile random_file(const Kind& kind, std::mt19937_64& random) {
  MadeUpFile file;
  std::normal_distribution<double> normal;
  const auto color = [&] {
    const auto bits = random();
    return mesh::Color{static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                       static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)};
  };
  for (std::size_t v = 0; v < kind.vertices; ++v) {
    file.positions.push_back({normal(random), normal(random), 100.0 + normal(random)});
    // One in four has none.
    if (kind.has_normals)
      file.normals.push_back(random() % 4 == 0
                                 ? std::array<float, 3>{}
                                 : std::array<float, 3>{static_cast<float>(normal(random)), 0.5F,
                                                        static_cast<float>(normal(random))});
    if (kind.has_colors) file.colors.push_back(color());
    if (kind.has_byte_colors) file.byte_colors.push_back(color());
  }
  for (std::size_t i = 0; i < kind.triangles; ++i) {
    const std::size_t base = i * kind.vertices / kind.triangles;
    mesh::Triangle t;
    for (auto& v : t)
      v = static_cast<std::uint32_t>(kind.is_local ? (base + random() % 50) % kind.vertices
                                                   : random() % kind.vertices);
    file.triangles.push_back(t);
    if (kind.has_face_colors) file.face_colors.push_back(color());
  }
  return file;
}

// A corner of the input as it must come out of the join.
struct Corner {
  std::uint64_t number;
  mesh::Vertex vertex;
  friend bool operator==(const Corner&, const Corner&) = default;
};

std::vector<Corner> looked_up(const facts::Catalog& catalog, const std::vector<MadeUpFile>& files) {
  std::vector<Corner> corners;
  std::uint64_t first = 0;
  for (std::size_t f = 0; f < files.size(); ++f) {
    const MadeUpFile& file = files[f];
    for (std::size_t i = 0; i < file.triangles.size(); ++i)
      for (const auto v : file.triangles[i]) {
        Corner corner{first + v, {}};
        corner.vertex.position = catalog.lattice.input_vertex(file.positions[v]);
        corner.vertex.fingerprint = facts::fingerprint_of(file.positions[v]);
        corner.vertex.normal = {0, 0, 0};
        if (!file.normals.empty() && file.normals[v] != std::array<float, 3>{})
          corner.vertex.normal =
              geometry::to_normal16(file.normals[v][0], file.normals[v][1], file.normals[v][2]);
        if (!file.byte_colors.empty())
          corner.vertex.color = catalog.color_scales[f].pick(file.colors[v], file.byte_colors[v]);
        else if (!file.colors.empty())
          corner.vertex.color = file.colors[v];
        if (!file.face_colors.empty()) {
          corner.vertex.color = file.face_colors[i];
          corner.number = face_corner_number(first + v, corners.size());
        }
        corners.push_back(corner);
      }
    first += file.positions.size();
  }
  return corners;
}

void expect_join_is_lookup(const std::vector<Kind>& kinds, std::size_t least_groups,
                           std::size_t least_slices) {
  std::mt19937_64 random(test_seed());
  std::vector<MadeUpFile> files;
  for (const Kind& kind : kinds) files.push_back(random_file(kind, random));
  const CommonFolder folder;
  const TestBuild build(folder);
  facts::Catalog catalog = store_files(build.workspace(), files, 40'000, 30'000);
  fit_lattice(catalog, files);
  std::vector<TriangleGroup> groups = request_vertices(build.workspace(), catalog);
  answer_requests(build.workspace(), catalog, groups);
  if (!world().is_root()) return;
  EXPECT_GE(groups.size(), least_groups);
  std::vector<Corner> joined;
  std::size_t slices = 0;
  for (const TriangleGroup& group : groups) {
    slices = std::max(slices, group.slices.size());
    const Piece piece = load_group(build.workspace(), catalog, group_task(group));
    EXPECT_EQ(piece.triangles.size(), group.triangle_count);
    EXPECT_EQ(piece.numbers.size(), piece.vertices.size());
    EXPECT_EQ(std::set(piece.numbers.begin(), piece.numbers.end()).size(), piece.numbers.size());
    EXPECT_TRUE(catalog.has_face_colors || std::is_sorted(piece.numbers.begin(), piece.numbers.end()));
    for (const mesh::Triangle& t : piece.triangles)
      for (const auto v : t) joined.push_back({piece.numbers.at(v), piece.vertices[v]});
  }
  EXPECT_GE(slices, least_slices);
  EXPECT_TRUE(joined == looked_up(catalog, files)) << "seed " << test_seed();
}

TEST(Join, IsALookUpForAFewTriangles) { expect_join_is_lookup({{5, 3}}, 1, 1); }

TEST(Join, IsALookUpForManyGroupsAndRanges) {
  Kind shuffled{300'000, 280'000};
  shuffled.has_normals = shuffled.has_colors = true;
  expect_join_is_lookup({shuffled}, 2, 3);
}

TEST(Join, IsALookUpWhereTrianglesNameVerticesNearby) {
  Kind local{300'000, 400'000};
  local.is_local = true;
  expect_join_is_lookup({local}, 3, 1);
}

TEST(Join, IsALookUpForFilesOfDifferentKinds) {
  Kind plain{1000, 2000};
  Kind with_normals{50'000, 90'000};
  with_normals.has_normals = true;
  Kind with_colors{100'000, 90'000};
  with_colors.has_colors = with_colors.has_byte_colors = true;
  expect_join_is_lookup({plain, with_normals, with_colors, plain}, 1, 2);
}

TEST(Join, GivesCornersOfColouredFacesVerticesOfTheirOwn) {
  Kind faces{50'000, 160'000};
  faces.has_face_colors = true;
  Kind plain{1000, 3000};
  plain.has_colors = true;
  expect_join_is_lookup({plain, faces, plain}, 2, 1);
}

TEST(Join, VisitsExactlyTheVerticesThatTrianglesUse) {
  std::mt19937_64 random(test_seed());
  const std::vector<MadeUpFile> files{random_file({200'000, 30'000}, random)};
  const CommonFolder folder;
  const TestBuild build(folder);
  facts::Catalog catalog = store_files(build.workspace(), files, 40'000, 30'000);
  std::vector<TriangleGroup> groups = request_vertices(build.workspace(), catalog);
  if (!world().is_root()) return;
  std::set<std::uint64_t> used;
  for (const mesh::Triangle& t : files[0].triangles) used.insert(t.begin(), t.end());
  const RequestedRanges ranges(catalog, groups);
  EXPECT_EQ(ranges.size(), 2U);
  std::vector<std::uint64_t> visited;
  for (std::size_t i = 0; i < ranges.size(); ++i)
    visit_requested(build.workspace(), catalog, ranges.task(i),
                    [&](std::uint64_t number, const std::array<double, 3>& position) {
                      visited.push_back(number);
                      EXPECT_EQ(position, files[0].positions[number]);
                    });
  EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));
  EXPECT_TRUE(std::equal(visited.begin(), visited.end(), used.begin(), used.end()));
}

// From every second corner the fan would leave the outline; the area tells.
TEST(Join, CutsPolygonsAsTheirCornersWant) {
  MadeUpFile file;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const double x = 3.0 * i;
    for (const auto& [a, b] : {std::pair{0.2, 0.2}, {0.0, 1.0}, {-1.0, -1.0}, {1.0, 0.0}})
      file.positions.push_back({x + a, b, 0.0});
    const std::uint32_t v = 4 * i;
    // From another corner on, every second one.
    const std::uint32_t turn = i % 2;
    file.triangles.push_back({v + turn, v + 1 + turn, v + 2 + turn});
    file.triangles.push_back({v + turn, v + 2 + turn, v + (3 + turn) % 4});
    file.polygons.push_back({2 * i, 4});
  }
  const CommonFolder folder;
  const TestBuild build(folder);
  facts::Catalog catalog = store_files(build.workspace(), {file}, 1000, 1000);
  fit_lattice(catalog, {file});
  std::vector<TriangleGroup> groups = request_vertices(build.workspace(), catalog);
  answer_requests(build.workspace(), catalog, groups);
  cut_polygons(build.workspace(), catalog, groups);
  EXPECT_EQ(catalog.counts.concave_polygons, 100U);
  EXPECT_EQ(catalog.counts.crossing_polygons, 0U);
  if (!world().is_root()) return;
  const Piece piece = load_group(build.workspace(), catalog, group_task(groups.at(0)));
  ASSERT_EQ(piece.triangles.size(), 200U);
  for (std::size_t i = 0; i < 200; i += 2) {
    double area = 0.0;
    std::set<std::uint64_t> corners;
    for (std::size_t k = i; k < i + 2; ++k) {
      std::array<std::array<double, 3>, 3> p;
      for (std::size_t c = 0; c < 3; ++c) {
        corners.insert(piece.numbers[piece.triangles[k][c]]);
        p[c] = file.positions[piece.numbers[piece.triangles[k][c]]];
      }
      area +=
          std::abs((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1])) /
          2.0;
    }
    EXPECT_EQ(corners.size(), 4U);
    EXPECT_NEAR(area, 1.2, 1e-9) << "what is covered twice, or beyond the outline, would be more";
  }
}

}  // namespace
}  // namespace colossus::pipeline::ingest
