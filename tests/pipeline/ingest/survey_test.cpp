// The survey of files on the disk: whatever their format, the join then finds what was written.
#include "pipeline/ingest/survey.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "pipeline/ingest/join.hpp"
#include "pipeline/test_build.hpp"

namespace colossus::pipeline::ingest {
namespace {

using Position = std::array<double, 3>;
using Face = std::vector<std::uint32_t>;

struct Input {
  std::vector<Position> positions;
  std::vector<Face> faces;
};

// Floats, so that every format keeps them; convex polygons of up to `most_corners` in planes z = const.
Input random_input(std::size_t faces, std::size_t most_corners, std::mt19937_64& random) {
  Input input;
  for (std::size_t f = 0; f < faces; ++f) {
    const std::size_t corners = 3 + random() % (most_corners - 2);
    Face face;
    const auto place = [&] { return static_cast<double>(random() % 1000); };
    const Position at{place(), place(), place()};
    for (std::size_t k = 0; k < corners; ++k) {
      const double angle = 6.0 * static_cast<double>(k) / static_cast<double>(corners);
      face.push_back(static_cast<std::uint32_t>(input.positions.size()));
      input.positions.push_back(
          {static_cast<float>(at[0] + std::cos(angle)), static_cast<float>(at[1] + std::sin(angle)), at[2]});
    }
    input.faces.push_back(face);
  }
  return input;
}

void write_obj(const Input& input, const std::filesystem::path& path) {
  std::ofstream file(path);
  for (const Position& p : input.positions) file << fmt::format("v {} {} {}\n", p[0], p[1], p[2]);
  for (const Face& face : input.faces) {
    file << "f";
    for (const auto v : face) file << " " << v + 1;
    file << "\n";
  }
}

void write_ply(const Input& input, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file << fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      input.positions.size(), input.faces.size());
  const auto put = [&](const auto& value) {
    file.write(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const Position& p : input.positions) put(p);
  for (const Face& face : input.faces) {
    put(static_cast<std::uint8_t>(face.size()));
    for (const auto v : face) put(v);
  }
}

std::size_t triangle_count(const Input& input) {
  std::size_t count = 0;
  for (const Face& face : input.faces) count += face.size() - 2;
  return count;
}

// The fan of each face, as it is before polygons are cut.
std::vector<Position> fans(const Input& input) {
  std::vector<Position> corners;
  for (const Face& face : input.faces)
    for (std::size_t k = 2; k < face.size(); ++k)
      for (const auto v : {face[0], face[k - 1], face[k]}) corners.push_back(input.positions[v]);
  return corners;
}

struct Written {
  std::string name;
  Input input;
};

void expect_found(const std::vector<Written>& files, std::uint64_t small_faces = 0) {
  const CommonFolder folder;
  facts::BuildOptions options;
  for (const Written& file : files) {
    if (world().is_root())
      (file.name.ends_with(".obj") ? write_obj : write_ply)(file.input, folder / file.name);
    options.inputs.push_back((folder / file.name).string());
  }
  world().barrier();
  const TestBuild build(folder, options);
  facts::Catalog catalog = survey(build.workspace());
  std::uint64_t triangles = 0, vertices = 0, polygons = 0;
  for (const Written& file : files) {
    triangles += triangle_count(file.input);
    vertices += file.input.positions.size();
    for (const Face& face : file.input.faces) polygons += face.size() > 3 ? 1 : 0;
  }
  EXPECT_EQ(catalog.counts.triangles, triangles);
  EXPECT_EQ(catalog.counts.vertices, vertices);
  EXPECT_EQ(catalog.counts.small_faces, small_faces);
  if (world().is_root()) {
    EXPECT_EQ(catalog.counts.polygons, polygons);
  }
  ASSERT_EQ(catalog.files.size(), files.size());
  std::uint64_t next = 0;
  for (const facts::VertexBlockRef& block : catalog.vertex_blocks) {
    EXPECT_EQ(block.first, next) << "numbered through";
    next += block.count;
  }
  EXPECT_EQ(next, vertices);
  catalog.bounds.add({-10.0, -10.0, -10.0});
  catalog.bounds.add({1010.0, 1010.0, 1010.0});
  catalog.lattice = geometry::Lattice::fit(catalog.bounds);
  std::vector<TriangleGroup> groups = request_vertices(build.workspace(), catalog);
  answer_requests(build.workspace(), catalog, groups);
  if (!world().is_root()) return;
  for (std::size_t f = 0; f < files.size(); ++f) {
    EXPECT_EQ(catalog.files[f].name, files[f].name);
    EXPECT_EQ(catalog.files[f].bytes, std::filesystem::file_size(folder / files[f].name));
    EXPECT_EQ(catalog.files[f].hash.size(), 32U);
  }
  std::vector<geometry::Point> expected, found;
  for (const Written& file : files)
    for (const Position& p : fans(file.input)) expected.push_back(catalog.lattice.input_vertex(p));
  for (const TriangleGroup& group : groups) {
    const Piece piece = load_group(build.workspace(), catalog, group_task(group));
    for (const mesh::Triangle& t : piece.triangles)
      for (const auto v : t) found.push_back(piece.vertices[v].position);
  }
  EXPECT_TRUE(found == expected) << "in the order of the faces";
}

TEST(Survey, FindsTrianglesInPartsOfFiles) {
  std::mt19937_64 random(test_seed());
  expect_found({{"a.ply", random_input(150'000, 3, random)}, {"b.obj", random_input(1000, 3, random)}});
}

TEST(Survey, FindsPolygons) {
  std::mt19937_64 random(test_seed());
  expect_found({{"a.obj", random_input(5000, 6, random)}, {"b.ply", random_input(5000, 6, random)}});
}

// Its size is that of triangles only, so that it is read in parts until one of them knows better.
TEST(Survey, ReadsAgainWhatOnlyLooksLikeTriangles) {
  std::mt19937_64 random(test_seed());
  Input input = random_input(300'000, 3, random);
  // A square takes 17 bytes, an edge 9: as many as two triangles.
  input.faces[250'000] = {0, 1, 2, 3};
  input.faces[250'001] = {0, 1};
  const CommonFolder folder;
  facts::BuildOptions options;
  options.inputs = {(folder / "a.ply").string(), (folder / "b.obj").string()};
  if (world().is_root()) {
    write_ply(input, folder / "a.ply");
    write_obj(random_input(10, 3, random), folder / "b.obj");
  }
  world().barrier();
  const TestBuild build(folder, options);
  const facts::Catalog catalog = survey(build.workspace());
  EXPECT_EQ(catalog.counts.triangles, 300'010U);
  EXPECT_EQ(catalog.counts.small_faces, 1U);
  EXPECT_EQ(run::last_phase(build.workspace()), 2U);
  EXPECT_TRUE(std::is_sorted(catalog.triangle_blocks.begin(), catalog.triangle_blocks.end(),
                             [](const auto& a, const auto& b) { return a.file < b.file; }));
}

TEST(Survey, RefusesInputWithoutTrianglesAndFilesThatAreNone) {
  const CommonFolder folder;
  if (world().is_root()) {
    write_obj({{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, {}}, folder / "empty.obj");
    write_obj({{{0.0, 0.0, 0.0}}, {{0, 0, 7}}}, folder / "index.obj");
  }
  world().barrier();
  for (const std::string name : {"empty.obj", "index.obj", "none.obj"}) {
    facts::BuildOptions options;
    options.inputs = {(folder / name).string()};
    const CommonFolder other;
    // Opening the build looks at names, so that of a file which is not there comes last.
    const auto error = error_of([&] {
      const TestBuild build(other, options);
      survey(build.workspace());
    });
    ASSERT_ALL(error.has_value()) << name;
    EXPECT_EQ(error->status(), core::Status::kBadData) << error->what();
    EXPECT_NE(std::string(error->what()).find(name), std::string::npos) << error->what();
  }
}

// Half a vertex per triangle where they are in order; three in a soup. Roughly, by a hash.
TEST(Survey, CountsTheVerticesThatBlocksUse) {
  Input grid, soup;
  for (std::uint32_t y = 0; y < 200; ++y)
    for (std::uint32_t x = 0; x < 200; ++x) {
      grid.positions.push_back({1.0 * x, 1.0 * y, 0.0});
      const std::uint32_t v = 200 * y + x;
      if (x > 0 && y > 0) {
        grid.faces.push_back({v, v - 1, v - 201});
        grid.faces.push_back({v, v - 201, v - 200});
      }
    }
  std::mt19937_64 random(test_seed());
  soup = random_input(30'000, 3, random);
  for (const auto& [input, vertices] : {std::pair{grid, 40'000.0}, {soup, 90'000.0}}) {
    const CommonFolder folder;
    facts::BuildOptions options;
    options.inputs = {(folder / "a.ply").string()};
    if (world().is_root()) write_ply(input, folder / "a.ply");
    world().barrier();
    const TestBuild build(folder, options);
    const facts::Catalog catalog = survey(build.workspace());
    if (world().is_root()) {
      EXPECT_NEAR(static_cast<double>(catalog.input_block_vertices), vertices, 0.05 * vertices);
    }
  }
}

}  // namespace
}  // namespace colossus::pipeline::ingest
