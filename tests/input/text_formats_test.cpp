// OBJ, STL and OFF.
#include <cstring>
#include <limits>
#include <random>

#include "support/input_testing.hpp"

namespace colossus::input {

using namespace support;
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;
using Positions = std::vector<std::array<double, 3>>;
using Normals = std::vector<std::array<float, 3>>;
using Colors = std::vector<std::array<std::uint8_t, 4>>;

constexpr const char* kObjVertices = "v 500000.001 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1e-3\n";

TEST(Obj, ReadsEveryFormOfFaces) {
  const TemporaryFolder folder;
  const auto source = open_source(folder.write(
      "a.obj", std::string("# comment\r\n\r\no thing\ng a b\ns off\n") + kObjVertices +
                   "f 1 2 3 # corner\nf -4 -3 -2 -1\r\nf 1// 2/7 3/7/ \\\n 4\nl 1 2\np 1\nf 1 2\nf\t+4 3 2"));
  EXPECT_EQ(source->info().skipped,
            (std::vector<std::string>{"g (groups)", "l (lines)", "o (names of objects)", "p (points)",
                                      "s (smoothing groups)"}));
  EXPECT_EQ(source->info().vertex_count, 4U);
  EXPECT_EQ(source->info().face_count, 5U);
  const Collected read = collect(*source);
  EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}, {3, 2, 1}}));
  EXPECT_EQ(read.noted.polygons, 2U);
  EXPECT_EQ(read.noted.small, 1U);
}

TEST(Obj, NegativeIndicesCountFromTheVerticesBeforeTheFace) {
  const TemporaryFolder folder;
  const Collected read = collect(folder.write(
      "a.obj",
      std::string(kObjVertices) + "f 1 2 3\nf -4 -3 -2 -1\nf 1/7 2/7 \\\r\n 3/7\nf 1 2\nv 9 9 9\nf -1 -2 2"));
  EXPECT_EQ(read.positions, (Positions{{500000.001, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.001}, {9, 9, 9}}));
  EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {4, 3, 1}}));
  EXPECT_EQ(read.noted.polygons, 1U);
  EXPECT_EQ(read.noted.small, 1U);
}

TEST(Obj, LinesMayContinueWhereTheBufferEnds) {
  const TemporaryFolder folder;
  std::string file = std::string(kObjVertices) + "f 1 2";
  file.resize((std::size_t{1} << 20) - 1, ' ');
  const Collected read = collect(folder.write("b.obj", file + "\\\r\n 3\n"));
  EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}}));
}

TEST(Obj, ReadsColoursOfBothScales) {
  const TemporaryFolder folder;
  const Collected unit = collect(folder.write("c.obj", "v 0 0 0 1 0.5 0\nv 0 0 0 0 0 1 0.5\n"));
  EXPECT_EQ(unit.colors, (Colors{{255, 128, 0, 255}, {0, 0, 255, 128}}));
  const Collected bytes = collect(folder.write("c.obj", "v 0 0 0 1 128 0\nv 0 0 0 0 0 255\n"));
  EXPECT_EQ(bytes.colors, (Colors{{1, 128, 0, 255}, {0, 0, 255, 255}}));
  const auto some = open_source(folder.write("c.obj", "v 0 0 0 1 128 0\nv 0 0 0 1.0\n"));
  const Collected read = collect(*some);
  EXPECT_EQ(read.colors, (Colors{{1, 128, 0, 255}, kNoColor}));
  EXPECT_EQ(read.noted.missing_colors, (Tally{1, 1}));
}

TEST(Obj, KeepsNormalsThatBelongToVertices) {
  const TemporaryFolder folder;
  const std::string start = std::string(kObjVertices) + "vn 0 0 1\nvn 0 1 0\nvn 0 0 1\n";
  const Collected same = collect(folder.write("n.obj", start + "f 1//1 2//2 3//-1\nf 1//3 3//1 2//2\n"));
  EXPECT_EQ(same.normals, (Normals{{0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}));
  for (const char* faces : {"f 1//1 2//2 3//1\nf 1//2 2//2 3//1\n", "f 1//9 2//2 3//1\n"}) {
    const auto different = open_source(folder.write("n.obj", start + faces));
    EXPECT_FALSE(different->info().has_normals);
    ASSERT_EQ(different->info().skipped.size(), 1U);
    EXPECT_NE(different->info().skipped[0].find("vn"), std::string::npos);
    EXPECT_TRUE(collect(*different).normals.empty());
  }
}

TEST(Obj, RefusesTexturesAndMaterials) {
  const TemporaryFolder folder;
  const auto path = folder.write(
      "t.obj", std::string("mtllib a.mtl\n") + kObjVertices + "vt 0 0\nusemtl red\nf 1/1 2/1 3/1\n");
  expect_bad(path, {"mtllib, usemtl, vt", "--drop-textures"});
  EXPECT_EQ(collect(path, {.drop_textures = true}).faces.size(), 1U);
}

TEST(Obj, BadDataNamesElementAndLine) {
  const TemporaryFolder folder;
  const auto bad = [&](const std::string& text, std::initializer_list<std::string_view> parts) {
    expect_bad(folder.write("b.obj", kObjVertices + text), parts);
  };
  bad("f 1 2 3\nf 1 2 5\n", {"face 1 (line 6)", "index 5", "expected 1 to 4"});
  bad("f 1 2 0\n", {"face 0 (line 5)", "index 0"});
  bad("f 1 2 -5\n", {"face 0 (line 5)", "index -5", "-4 to -1"});
  bad("f 1 2 -9223372036854775808\n", {"face 0"});
  bad("f 1 2 9223372036854775807\n", {"face 0"});
  bad("f 1 2 3x\n", {"face 0 (line 5)", "corner", "'3x'"});
  bad("f 1 2 3/1/1/1\n", {"face 0", "'3/1/1/1'"});
  bad("v 1 2\n", {"vertex 4 (line 5)", "found 2 numbers"});
  bad("v 1 2 3 4 5\n", {"vertex 4 (line 5)", "found 5 numbers"});
  bad("v 1 2 3 4 5 6 7 8\n", {"vertex 4 (line 5)", "at most 7"});
  bad("v 1 two 3\n", {"vertex 4 (line 5)", "number", "'two'"});
  expect_bad(folder.write("e.obj", "# nothing\n"), {"no vertices"});
}

std::string stl_facet(const char* a, const char* b, const char* c) {
  return fmt::format(
      "facet normal 0 0 1\n outer loop\n  vertex {}\n  vertex {}\n  vertex {}\n endloop\nendfacet\n", a, b,
      c);
}

TEST(Stl, ReadsSolidsInText) {
  const TemporaryFolder folder;
  const Collected read = collect(folder.write(
      "a.stl", "solid a b\n" + stl_facet("500000.001 0 0", "1 0 0", "0 1 0") + "endsolid a b\nSOLID\r\n" +
                   stl_facet("1 0 0", "1 0 0", "0 1 -2e-3") + "EndSolid"));
  EXPECT_EQ(read.positions,
            (Positions{{500000.001, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, -0.002}}));
  EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}, {3, 4, 5}}));
}

TEST(Stl, TruncatedTextIsAnErrorAtEveryLength) {
  const TemporaryFolder folder;
  const std::string file =
      "solid a\n" + stl_facet("0 0 0", "1 0 0", "0 1 0") + stl_facet("0 0 0", "1 0 0", "0 1 0") + "endsolid";
  ASSERT_EQ(collect(folder.write("cut.stl", file)).faces.size(), 2U);
  for (std::size_t size = 0; size < file.size(); ++size)
    ASSERT_FALSE(bad_data_message(folder.write("cut.stl", file.substr(0, size))).empty()) << size;
  expect_bad(folder.write("cut.stl", file.substr(0, 180)), {"truncated in triangle 1", "expected"});
}

TEST(Stl, BadTextNamesTriangleAndLine) {
  const TemporaryFolder folder;
  const std::string start = "solid\n" + stl_facet("0 0 0", "1 0 0", "0 1 0");
  expect_bad(folder.write("b.stl", start + stl_facet("0 0 0", "1 x 0", "0 1 0") + "endsolid\n"),
             {"triangle 1 (line 12)", "a number", "found x"});
  expect_bad(folder.write("b.stl", start + stl_facet("0 0 0", "1 0 0", "0 nan 0") + "endsolid\n"),
             {"triangle 1", "coordinate y of corner 2 is nan"});
  expect_bad(folder.write("b.stl", start + "face\n"),
             {"triangle 1 (line 9)", "expected facet", "found face"});
  expect_bad(folder.write("b.stl", "solid\nendsolid\n"), {"no vertices"});
}

std::string binary_stl(const std::vector<std::array<std::array<float, 3>, 3>>& triangles,
                       std::string header = {}) {
  header.resize(80);
  const auto count = static_cast<std::uint32_t>(triangles.size());
  header.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& triangle : triangles) {
    header.append(12, '\x7f');
    header.append(reinterpret_cast<const char*>(&triangle), sizeof(triangle));
    header.append(2, '\x55');
  }
  return header;
}

std::vector<std::array<std::array<float, 3>, 3>> random_soup(std::size_t count) {
  std::mt19937 random(5);
  std::vector<std::array<std::array<float, 3>, 3>> triangles(count);
  for (auto& triangle : triangles)
    for (auto& corner : triangle)
      for (float& value : corner) value = static_cast<float>(random()) - 1e9F;
  return triangles;
}

TEST(Stl, ReadsBinaryFilesInParts) {
  const TemporaryFolder folder;
  const auto triangles = random_soup(70000);
  for (const char* header : {"", "solid fooled you"}) {
    const auto source = open_source(folder.write("b.stl", binary_stl(triangles, header)));
    EXPECT_EQ(source->info().format, "STL binary");
    EXPECT_EQ(source->parts().size(), 3U);
    const Collected read = collect(*source);
    ASSERT_EQ(read.faces.size(), triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
          ASSERT_EQ(read.positions[read.faces[i][k]][axis], triangles[i][k][axis]);
  }
}

TEST(Stl, BadBinaryFilesAreErrors) {
  const TemporaryFolder folder;
  auto triangles = random_soup(3);
  const std::string file = binary_stl(triangles);
  for (std::size_t size = 0; size < file.size(); ++size)
    ASSERT_FALSE(bad_data_message(folder.write("cut.stl", file.substr(0, size))).empty()) << size;
  expect_bad(folder.write("cut.stl", file.substr(0, 190)),
             {"truncated in triangle 2", "expected 234 bytes, found 190"});
  expect_bad(folder.write("long.stl", file + std::string(50, 'x')),
             {"header of this binary STL lies", "expected 234 bytes, found 284", "the size of 4 triangles"});
  std::string unfilled = file;
  unfilled.replace(80, 4, 4, '\0');
  expect_bad(folder.write("unfilled.stl", unfilled), {"it says 0 triangles", "the size of 3 triangles"});
  triangles[2][1][0] = std::numeric_limits<float>::infinity();
  expect_bad(folder.write("inf.stl", binary_stl(triangles)),
             {"triangle 2", "coordinate x of corner 1 is inf"});
  expect_bad(folder.write("none.stl", binary_stl({})), {"no vertices"});
}

TEST(Off, ReadsEveryHeader) {
  const TemporaryFolder folder;
  const std::string body =
      "0 0 0\n500000.001 0 0 # far\n\n# comment\n0 1 0\n0 0 1\n3 0 1 2\n4 0 1 2 3  255 0 0\n2 0 1\n";
  for (const char* header : {"OFF\n4 3 0\n", "OFF 4 3 0\n", "OFF4 3 0\n", "# c\nOFF # c\n# c\n4 3\n",
                             "4 3 0\n", "OFF\r\n4 3 5\r\n"}) {
    SCOPED_TRACE(header);
    const Collected read = collect(folder.write("a.off", header + body));
    EXPECT_EQ(read.positions, (Positions{{0, 0, 0}, {500000.001, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
    EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(read.noted.polygons, 1U);
    EXPECT_EQ(read.noted.small, 1U);
  }
}

TEST(Off, ReadsNormalsAndColours) {
  const TemporaryFolder folder;
  const Collected bytes = collect(folder.write("c.off", "COFF\n2 0 0\n0 0 0 1 0 255 9\n1 0 0 0 0 0 255\n"));
  EXPECT_EQ(bytes.colors, (Colors{{1, 0, 255, 9}, {0, 0, 0, 255}}));
  const Collected floats =
      collect(folder.write("c.off", "CNOFF\n2 0 0\n0 0 0  0 0 1  1 0 0\n1 0 0  0 1 0  0 0.5 0\n"));
  EXPECT_EQ(floats.colors, (Colors{{255, 0, 0, 255}, {0, 128, 0, 255}}));
  EXPECT_EQ(floats.normals, (Normals{{0, 0, 1}, {0, 1, 0}}));
  const Collected ones = collect(folder.write("c.off", "COFF\n2 0 0\n0 0 0 1 0 0\n1 0 0 0 1 1\n"));
  EXPECT_EQ(ones.colors, (Colors{{255, 0, 0, 255}, {0, 255, 255, 255}}));
  const auto textured = folder.write("c.off", "STCOFF\n1 0 0\n0 0 0 8 8 8 0.5 0.5\n");
  expect_bad(textured, {"vertex.st", "--drop-textures"});
  EXPECT_EQ(collect(textured, {.drop_textures = true}).colors, (Colors{{8, 8, 8, 255}}));
}

TEST(Off, TruncationIsAnErrorAtEveryLength) {
  const TemporaryFolder folder;
  const std::string file = "COFF\n3 2 0\n0 0 0 1 1 1\n1 0 0 1 1 1\n0 1 0 1 1 1\n3 0 1 2\n3 2 1 0";
  ASSERT_EQ(collect(folder.write("cut.off", file)).faces.size(), 2U);
  for (std::size_t size = 0; size < file.size(); ++size)
    ASSERT_FALSE(bad_data_message(folder.write("cut.off", file.substr(0, size))).empty()) << size;
}

TEST(Off, BadDataNamesElementAndLine) {
  const TemporaryFolder folder;
  const auto bad = [&](const std::string& text, std::initializer_list<std::string_view> parts) {
    expect_bad(folder.write("b.off", text), parts);
  };
  bad("OFF\n2 1 0\n0 0 0\n1 1 1\n3 0 1 2\n", {"face 0", "index 2", "expected 0 to 1"});
  bad("OFF\n2 1 0\n0 0 0\n1 1 1\n3 0 1 -1\n", {"face 0", "index -1"});
  bad("OFF\n2 1 0\n0 0 0\n1 1 1\n3 0 1\n", {"truncated in face 0", "the end of the file"});
  bad("OFF\n2 2 0\n0 0 0\n1 1 1\n3 0 1\n1 0 1 1\n", {"face 0 (line 6)", "3 corners on line 5"});
  bad("OFF\n2 1 0\n0 0 0\n1 1\n3 0 1 1\n", {"vertex 1 (line 4)", "the end of the line"});
  bad("OFF\n2 1 0\n0 0 0\n1 1 1\n-3 0 1 1\n", {"face 0", "-3 corners"});
  bad("OFF\n2 1 0\n0 0 0\n1 1 1\n3 0 1 1\n3 0 1 1\n", {"line 6", "end of the file"});
  bad("OFF\n2 9 0\n0 0 0\n1 1 1\n3 0 1 1\n", {"truncated in face 1"});
  bad("OFF\n9223372036854775807 1 0\n0 0 0\n", {"9223372036854775807 vertices", "at most 4294967295"});
  bad("OFF\n-1 1 0\n0 0 0\n", {"header (line 2)", "'-1'"});
  bad("4OFF\n1 0 0\n0 0 0 0\n", {"header", "'4OFF'"});
  bad("OFF BINARY\n1 0 0\n", {"OFF BINARY"});
  bad("OFF\n0 0 0\n", {"no vertices"});
}

}  // namespace
}  // namespace colossus::input
