#include "exporters/ply.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "core/file.hpp"
#include "reader/diamonds/extract.hpp"
#include "support/diamonds_fixture.hpp"

namespace colossus::reader::diamonds {

using namespace support;
namespace {

struct Ply {
  std::string header;
  access::CutMesh mesh;
  std::vector<std::array<float, 3>> normals;
};

// Reads back exactly what extract() writes.
Ply read_ply(const std::filesystem::path& path) {
  const core::Bytes bytes = core::read_file(path);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t body = text.find("end_header\n") + 11;
  Ply ply;
  ply.header = text.substr(0, body);
  const auto number_after = [&](const std::string& key) {
    return std::stoul(ply.header.substr(ply.header.find(key) + key.size()));
  };
  const bool has_doubles = ply.header.find("property double x") != std::string::npos;
  core::ByteReader reader(std::span<const std::byte>(bytes).subspan(body));
  const auto vertices = number_after("element vertex ");
  for (std::size_t i = 0; i < vertices; ++i) {
    verify::measure::WorldPoint p{};
    for (double& c : p) c = has_doubles ? reader.get<double>() : reader.get<float>();
    ply.mesh.positions.push_back(p);
    ply.normals.push_back(reader.get<std::array<float, 3>>());
    ply.mesh.colors.push_back(reader.get<mesh::Color>());
  }
  const auto faces = number_after("element face ");
  for (std::size_t i = 0; i < faces; ++i) {
    EXPECT_EQ(reader.get<std::uint8_t>(), 3);
    ply.mesh.triangles.push_back(reader.get<mesh::Triangle>());
  }
  EXPECT_FALSE(reader.failed());
  EXPECT_EQ(reader.remaining(), 0U);
  return ply;
}

TEST(Extract, WritesTheCutWithItsAttributes) {
  DiamondsFixture fixture(torus(40, 24), 200);
  const auto statue = fixture.open();
  const Cut cut = cut_at_level(*statue, 3);
  const access::CutMesh mesh = assemble(*statue, cut);
  const auto path = fixture.folder() / "cut.ply";
  const exporters::WrittenPly result = exporters::write_ply(assemble(*statue, cut), path);
  const Ply ply = read_ply(path);
  EXPECT_TRUE(result.has_doubles);
  EXPECT_EQ(result.vertices, mesh.positions.size());
  EXPECT_EQ(result.triangles, mesh.triangles.size());
  EXPECT_EQ(ply.mesh.positions, mesh.positions);
  EXPECT_EQ(ply.mesh.triangles, mesh.triangles);
  EXPECT_EQ(ply.mesh.colors, mesh.colors);
  for (std::size_t i = 0; i < ply.normals.size(); ++i) {
    const auto expected = geometry::decode_octahedral(mesh.normals[i]);
    for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(ply.normals[i][k], static_cast<float>(expected[k]));
  }
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".part"));
}

TEST(Extract, TheFinestCutIsTheInput) {
  const WorldMesh input = torus(40, 24);
  DiamondsFixture fixture(input, 200, 16);
  const auto statue = fixture.open();
  const access::CutMesh mesh = assemble(*statue, cut_at_level(*statue, 99));
  const auto distances =
      verify::measure::surface_distances({mesh.positions, mesh.triangles}, input.surface(), 20000);
  double error = 0.0;
  for (access::RowIndex row = 0; row < statue->rows().size(); ++row)
    if (statue->is_leaf(row)) error = std::max(error, statue->rows()[row].error);
  EXPECT_LE(distances.a_to_b.max, error);
  EXPECT_LE(distances.b_to_a.max, error);
}

TEST(Extract, FloatsOnlyWhereTheyAreExact) {
  access::CutMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0.5, 2}, {4, 0.25, -1e6}, {0x1p-20, 0x1p60, 1 + 0x1p-23}};
  EXPECT_TRUE(exporters::fits_floats(mesh));
  mesh.positions.push_back({0, 0, 1 + 0x1p-24});
  EXPECT_FALSE(exporters::fits_floats(mesh));
}

TEST(Extract, CoarsePositionsOnASimpleLatticeAreWrittenAsFloats) {
  // The root's corners are multiples of 2^30, so eight bits of weight give multiples of 2^22.
  DiamondsFixture fixture(sphere(2), 1000, 8);
  fixture.metadata.lattice.origin = {0, 0, 0};
  fixture.metadata.lattice.step = 1;
  const auto statue = fixture.open();
  const auto path = fixture.folder() / "cut.ply";
  const Cut cut = cut_at_level(*statue, 0);
  const access::CutMesh mesh = assemble(*statue, cut);
  EXPECT_FALSE(exporters::write_ply(assemble(*statue, cut), path).has_doubles);
  const Ply ply = read_ply(path);
  EXPECT_EQ(ply.mesh.positions, mesh.positions);
  EXPECT_EQ(ply.mesh.triangles, mesh.triangles);
}

TEST(Extract, PointsThatFallTogetherInTheWorldAreOne) {
  // 2^52 away from the origin, doubles have steps of 1: finer lattice positions coincide.
  DiamondsFixture fixture(sphere(3), 100);
  fixture.metadata.lattice.origin = {0x1p52, 0x1p52, 0x1p52};
  fixture.metadata.lattice.step = 0x1p-25;
  fixture.write();
  const Statue statue(fixture.path());
  const access::CutMesh mesh = assemble(statue, cut_at_level(statue, 99));
  EXPECT_FALSE(mesh.triangles.empty());
  EXPECT_LT(mesh.triangles.size(), mesh.stored_triangles);
  EXPECT_EQ(census_of(mesh).repeated_points, 0U);
  for (const auto& t : mesh.triangles) EXPECT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
}

TEST(Extract, LeavesNothingBehindWhenItFails) {
  DiamondsFixture fixture(sphere(3), 100);
  const auto statue = fixture.open();
  const auto path = fixture.folder() / "missing" / "cut.ply";
  try {
    exporters::write_ply(assemble(*statue, cut_at_level(*statue, 1)), path);
    ADD_FAILURE() << "no error";
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kCannotCreate);
  }
  const auto folder = fixture.folder() / "folder";
  std::filesystem::create_directories(folder / "full");
  EXPECT_THROW(exporters::write_ply(assemble(*statue, cut_at_level(*statue, 1)), folder), core::Error);
  EXPECT_FALSE(std::filesystem::exists(folder.string() + ".part"));
}

}  // namespace
}  // namespace colossus::reader::diamonds
