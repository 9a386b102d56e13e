// However the root cube is divided into buckets: together they are the mesh that one bucket makes of it all.
#include "pipeline/buckets/attributes.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "pipeline/test_build.hpp"

namespace colossus::pipeline::buckets {
namespace {

using geometry::Point;

void split(const CubeId& cube, std::mt19937_64& random, std::vector<CubeId>& cubes) {
  if (cube.level == 4 || (cube.level > 0 && random() % 2 == 0)) {
    cubes.push_back(cube);
    return;
  }
  for (int octant = 0; octant < 8; ++octant) split(cube.child(octant), random, cubes);
}

mesh::Color random_color(std::mt19937_64& random) {
  const auto bits = random();
  return {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
          static_cast<std::uint8_t>(bits >> 16), 255};
}

// A rough sheet as a soup, where each triangle has vertices of its own; with copies, triangles that are
// turned over, a third sheet on an edge, and slivers that collapse.
MadeUpFile rough_soup(bool has_normals, std::mt19937_64& random) {
  constexpr int kSide = 40;
  std::uniform_real_distribution<double> height(0.0, 0.7);
  std::vector<std::array<double, 3>> points;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) points.push_back({1.0 * x, 1.0 * y, height(random)});
  MadeUpFile file;
  const auto add = [&](const std::array<std::array<double, 3>, 3>& corners) {
    const auto first = static_cast<std::uint32_t>(file.positions.size());
    for (const auto& corner : corners) {
      file.positions.push_back(corner);
      file.colors.push_back(random_color(random));
      if (has_normals) file.normals.push_back({0.1F, static_cast<float>(height(random)), 1.0F});
    }
    file.triangles.push_back({first, first + 1, first + 2});
  };
  for (int y = 1; y < kSide; ++y)
    for (int x = 1; x < kSide; ++x) {
      const auto& a = points[static_cast<std::size_t>(kSide * (y - 1) + x - 1)];
      const auto& b = points[static_cast<std::size_t>(kSide * (y - 1) + x)];
      const auto& c = points[static_cast<std::size_t>(kSide * y + x)];
      const auto& d = points[static_cast<std::size_t>(kSide * y + x - 1)];
      add({a, b, c});
      if (random() % 10 == 0) add({c, b, a});
      if (random() % 10 == 0) add({b, c, a});
      random() % 10 == 0 ? add({a, d, c}) : add({a, c, d});
      if (random() % 20 == 0) add({a, c, {a[0], a[1], a[2] + 3.0}});
      if (random() % 20 == 0) add({a, {a[0] + 1e-12, a[1], a[2]}, {a[0], a[1] + 1e-12, a[2]}});
    }
  // Larger than most buckets.
  add({points[0], points[kSide * kSide - 1], {0.0, 40.0, 5.0}});
  return file;
}

using Corners = std::array<Point, 3>;

Corners corners_of(const mesh::Mesh& mesh, const mesh::Triangle& t) {
  Corners corners{mesh.vertices[t[0]].position, mesh.vertices[t[1]].position, mesh.vertices[t[2]].position};
  std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  return corners;
}

void expect_one_mesh(bool has_normals, const Rounding& rounding) {
  std::mt19937_64 random(test_seed());
  const MadeUpFile file = rough_soup(has_normals, random);
  std::vector<CubeId> cubes;
  split({}, random, cubes);
  const CommonFolder folder;
  const TestBuild build(folder);
  const run::Workspace& workspace = build.workspace();
  facts::Catalog catalog = store_files(workspace, {file}, 1000, 1000);
  fit_lattice(catalog, {file});
  auto groups = ingest::request_vertices(workspace, catalog);
  ingest::answer_requests(workspace, catalog, groups);
  // More triangles would be needed for several buckets than make a test, so they are chosen here.
  core::Bytes task;
  if (world().is_root()) task = ingest::group_task(groups.at(0));
  world().broadcast(task);
  const ingest::Piece whole = ingest::load_group(workspace, catalog, task);
  Buckets buckets{BucketTree(cubes), {}};
  std::vector<std::vector<std::uint32_t>> wanted(cubes.size());
  std::vector<std::uint32_t> met;
  for (std::uint32_t i = 0; i < whole.triangles.size(); ++i) {
    Point low = rounding(whole.vertices[whole.triangles[i][0]].position);
    Point high = low;
    for (const auto v : whole.triangles[i])
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], rounding(whole.vertices[v].position)[axis]);
        high[axis] = std::max(high[axis], rounding(whole.vertices[v].position)[axis]);
      }
    buckets.tree.find(low, high, met);
    for (const auto bucket : met) wanted[bucket].push_back(i);
  }
  for (const CubeId& cube : cubes) buckets.buckets.push_back({cube, 0, 0, {}});
  run_phase(
      workspace, "pieces", cubes.size(),
      [](std::size_t i) {
        core::ByteWriter writer;
        writer.put(i);
        return writer.take();
      },
      [&](std::span<const std::byte> bytes) {
        ingest::PieceCutter cutter(whole);
        const ingest::Piece piece = cutter.take(wanted[core::ByteReader(bytes).get<std::size_t>()]);
        core::ByteWriter writer;
        writer.put(store_piece(workspace, catalog, piece));
        return writer.take();
      },
      [&](std::size_t i, const core::Bytes& bytes) {
        buckets.buckets[i].triangle_count = wanted[i].size();
        buckets.buckets[i].vertex_count = 3 * wanted[i].size();
        buckets.buckets[i].pieces = {core::ByteReader(bytes).get<scratch::RecordRef>()};
      });
  const std::vector<BucketRecord> records = give_attributes(workspace, catalog, std::move(buckets), rounding);
  if (!world().is_root()) return;

  BucketMesh expected(
      rounding, CubeId{},
      {catalog.lattice.input_vertex(catalog.bounds.low), catalog.lattice.input_vertex(catalog.bounds.high)},
      ingest::Piece(whole));
  const BucketCounts& counts = expected.counts();
  EXPECT_EQ(catalog.counts.merged_vertices, counts.merged_vertices);
  EXPECT_EQ(catalog.counts.attribute_seams, counts.attribute_seams);
  EXPECT_EQ(catalog.counts.color_seams, counts.color_seams);
  EXPECT_EQ(catalog.counts.duplicate, counts.duplicates);
  EXPECT_EQ(catalog.counts.opposite, counts.opposites);
  EXPECT_EQ(catalog.counts.collinear, counts.collinear);
  EXPECT_EQ(catalog.counts.border_edges, counts.input.border);
  EXPECT_EQ(catalog.counts.nonmanifold_edges, counts.input.nonmanifold);
  EXPECT_EQ(catalog.counts.inconsistent_edges, counts.input.inconsistent);
  EXPECT_GT(counts.duplicates, 0U);
  EXPECT_GT(counts.opposites, 0U);
  EXPECT_GT(counts.input.nonmanifold, 0U);
  EXPECT_GT(counts.input.inconsistent, 0U);
  EXPECT_NEAR(catalog.area, counts.area, 1e-12 * counts.area);

  std::map<Point, mesh::Vertex> vertices;
  for (const mesh::Triangle& t : expected.mesh().triangles)
    for (const auto v : t) vertices[expected.mesh().vertices[v].position] = expected.mesh().vertices[v];
  std::map<Corners, int> triangles, found;
  for (const mesh::Triangle& t : expected.mesh().triangles) ++triangles[corners_of(expected.mesh(), t)];
  EXPECT_GT(records.size(), 8U);
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (i > 0) {
      EXPECT_LE(records[i].triangle_count, records[i - 1].triangle_count) << "the largest first";
    }
    const LoadedBucket bucket = load_bucket(workspace, bucket_task(records[i]));
    EXPECT_EQ(bucket.cube, records[i].cube);
    for (const mesh::Triangle& t : bucket.mesh.triangles) {
      const Corners corners = corners_of(bucket.mesh, t);
      // The one that owns its least corner counts it; all that have it agree.
      if (bucket.cube.contains(corners[0], geometry::kRootBits)) ++found[corners];
      EXPECT_TRUE(triangles.contains(corners));
      for (const auto v : t) {
        const mesh::Vertex& vertex = bucket.mesh.vertices[v];
        ASSERT_TRUE(vertices.contains(vertex.position));
        EXPECT_EQ(vertex.normal, vertices[vertex.position].normal);
        EXPECT_EQ(vertex.color, vertices[vertex.position].color);
      }
    }
  }
  EXPECT_TRUE(found == triangles);
}

TEST(Attributes, AreThoseOfOneMeshWithNormalsThatAreComputed) { expect_one_mesh(false, {}); }
TEST(Attributes, AreThoseOfOneMeshWithNormalsThatWereRead) { expect_one_mesh(true, {}); }
TEST(Attributes, AreThoseOfOneMeshOfRoundedPositions) { expect_one_mesh(false, {1 << 22}); }

// The error of a build of these triangles, up to their attributes.
std::optional<core::Error> error_of_attributes(const MadeUpFile& file, std::uint64_t memory_bytes) {
  const CommonFolder folder;
  const TestBuild build(folder, {}, false, memory_bytes);
  facts::Catalog catalog = store_files(build.workspace(), {file}, 1000, 1000);
  fit_lattice(catalog, {file});
  auto groups = ingest::request_vertices(build.workspace(), catalog);
  ingest::answer_requests(build.workspace(), catalog, groups);
  return error_of([&] {
    give_attributes(build.workspace(), catalog, fill_buckets(build.workspace(), catalog, groups, {}, {10}),
                    {});
  });
}

TEST(Attributes, RefuseABucketThatIsTooCrowded) {
  std::mt19937_64 random(test_seed());
  const MadeUpFile file = rough_soup(false, random);
  EXPECT_FALSE(error_of_attributes(file, std::uint64_t{1} << 30));
  const auto error = error_of_attributes(file, std::uint64_t{96} << 20);
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kNoResources);
  EXPECT_NE(std::string(error->what()).find("triangles crowd"), std::string::npos);
}

TEST(Attributes, RefuseInputWithoutASurface) {
  MadeUpFile line;
  for (std::uint32_t v = 0; v < 100; ++v) {
    line.positions.push_back({1.0 * v, 2.0 * v, 3.0 * v});
    if (v >= 2) line.triangles.push_back({v - 2, v - 1, v});
  }
  const auto error = error_of_attributes(line, std::uint64_t{1} << 30);
  ASSERT_ALL(error.has_value());
  EXPECT_EQ(error->status(), core::Status::kBadData);
  EXPECT_NE(std::string(error->what()).find("no triangle with an area"), std::string::npos);
}

TEST(BucketMeshBytes, GrowWithTrianglesAndVertices) {
  for (std::uint64_t n = 1; n < 100'000'000; n *= 3) {
    EXPECT_GT(bucket_mesh_bytes(2 * n, n), bucket_mesh_bytes(n, n));
    EXPECT_GE(bucket_mesh_bytes(n, 2 * n), bucket_mesh_bytes(n, n));
  }
}

}  // namespace
}  // namespace colossus::pipeline::buckets
