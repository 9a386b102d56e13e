// What open_source() and expand_inputs() decide.
#include <type_traits>

#include "support/input_testing.hpp"

namespace colossus::input {

using namespace support;
namespace {

static_assert(std::is_trivially_copyable_v<Part>, "parts are sent to other ranks");

TEST(Source, ContentDecidesBeforeTheExtension) {
  const TemporaryFolder folder;
  const std::string ply =
      ply_header(BodyFormat::kAscii, fmt::format("element vertex 1\n{}", kFloatVertex)) + "0 0 0\n";
  EXPECT_EQ(open_source(folder.write("a.obj", ply))->info().format, "PLY ascii");
  EXPECT_EQ(open_source(folder.write("a", "OFF\n1 0 0\n0 0 0\n"))->info().format, "OFF");
  EXPECT_EQ(open_source(folder.write("a", "# c\n\nv 0 0 0\n"))->info().format, "OBJ");
  EXPECT_EQ(open_source(folder.write("a", "solid\nendsolid\n"))->info().format, "STL ascii");
  EXPECT_EQ(open_source(folder.write("A.OBJ", "v 0 0 0\n"))->info().format, "OBJ");
}

TEST(Source, FilesThatAreNoMeshAreBadData) {
  const TemporaryFolder folder;
  expect_bad(folder.path() / "missing.ply", {"cannot open"});
  expect_bad(folder.path(), {"is a folder", "expected a regular file"});
  expect_bad(folder.write("empty.ply", ""), {"is empty"});
  expect_bad(folder.write("a.ply.gz", "\x1f\x8b\x08"), {"gzip"});
  expect_bad(folder.write("a.txt", "hello\n"), {"unknown format", "PLY, OBJ, STL or OFF"});
  expect_bad(folder.write("a.ply", "x 0 0 0\n"), {"header line 1", "expected 'ply'", "'x 0 0 0'"});
}

TEST(Source, DescribesTheFile) {
  const TemporaryFolder folder;
  const std::string ply =
      ply_header(BodyFormat::kAscii, fmt::format("element vertex 1\n{}element face 0\nproperty list "
                                                 "uchar int vertex_index\n",
                                                 kFloatVertex)) +
      "0 0 0\n";
  const auto path = folder.write("a.ply", ply);
  const auto source = open_source(path);
  EXPECT_EQ(source->info().path, path);
  EXPECT_EQ(source->info().bytes, ply.size());
  EXPECT_EQ(source->info().vertex_count, 1U);
  EXPECT_EQ(source->info().face_count, 0U);
  EXPECT_TRUE(source->info().skipped.empty());
  EXPECT_TRUE(collect(*source).faces.empty()) << "no triangles is the caller's error, not ours";
}

TEST(ExpandInputs, ListsAreRelativeToTheirFolder) {
  const TemporaryFolder folder;
  const auto list =
      folder.write("list.txt", "\xEF\xBB\xBF# scans\n\na.ply\r\n  sub/b c.obj \n/abs/d.ply\n#x\n@e.ply");
  const std::vector<std::string> arguments{"first.ply", fmt::format("@{}", list.string()), "last.ply"};
  const std::vector<std::filesystem::path> expected{
      "first.ply",  folder.path() / "a.ply",  folder.path() / "sub/b c.obj",
      "/abs/d.ply", folder.path() / "@e.ply", "last.ply"};
  EXPECT_EQ(expand_inputs(arguments), expected);
}

TEST(ExpandInputs, ListsThatNameNothingAreBadData) {
  const TemporaryFolder folder;
  const auto message = [](const std::string& argument) -> std::string {
    try {
      expand_inputs(std::vector<std::string>{argument});
    } catch (const core::Error& error) {
      EXPECT_EQ(error.status(), core::Status::kBadData);
      return error.what();
    }
    return {};
  };
  EXPECT_NE(message(fmt::format("@{}", folder.write("l.txt", "# none\n").string())).find("found none"),
            std::string::npos);
  EXPECT_NE(message(fmt::format("@{}", (folder.path() / "missing.txt").string())).find("cannot open"),
            std::string::npos);
}

}  // namespace
}  // namespace colossus::input
