// PLY files that are wrong: each is an Error(kBadData) that says where, what was expected and what was found.
#include <limits>

#include "input/load.hpp"
#include "support/input_testing.hpp"

namespace colossus::input {

using namespace support;
namespace {

constexpr BodyFormat kFormats[] = {BodyFormat::kAscii, BodyFormat::kLittle, BodyFormat::kBig};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Three vertices, and faces as given.
std::string small_file(BodyFormat format, const std::vector<std::vector<double>>& faces,
                       std::string_view index_type = "int", double third_x = 0) {
  PlyBody body(format);
  body.put("float", 0).put("float", 0).put("float", 0).end_row();
  body.put("float", 1).put("float", 0).put("float", 0).end_row();
  body.put("float", third_x).put("float", 1).put("float", 0).end_row();
  for (const auto& face : faces) body.list("uchar", index_type, face).end_row();
  return ply_header(
             format,
             fmt::format("element vertex 3\n{}element face {}\nproperty list uchar {} vertex_indices\n",
                         kFloatVertex, faces.size(), index_type)) +
         body.bytes();
}

TEST(PlyBadData, TruncationAtEveryLengthIsAnError) {
  const TemporaryFolder folder;
  std::vector<std::string> files;
  for (const BodyFormat format : kFormats) {
    files.push_back(small_file(format, {{0, 1, 2}, {2, 1, 0}}));
    files.push_back(small_file(format, {{0, 1, 2, 1}, {2, 1, 0}}));
    PlyBody strips(format);
    strips.put("uchar", 0).put("uchar", 0).put("uchar", 0).end_row();
    strips.list("int", "int", {0, 0, 0, -1, 0}).end_row().list("uchar", "short", {1}).put("int", 4).end_row();
    files.push_back(ply_header(format,
                               "element vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z\n"
                               "element tristrips 1\nproperty list int int vertex_indices\n"
                               "element extra 1\nproperty list uchar short a\nproperty int b\n") +
                    strips.bytes());
  }
  for (const std::string& file : files) {
    ASSERT_NO_THROW(collect(folder.write("whole.ply", file)));
    // A text that lacks only its last line end is whole.
    const std::size_t whole = file.ends_with('\n') ? file.size() - 1 : file.size();
    for (std::size_t size = 0; size < whole; ++size) {
      const std::string message = bad_data_message(folder.write("cut.ply", file.substr(0, size)));
      ASSERT_FALSE(message.empty()) << size << " of " << file.size() << " bytes of " << file.substr(0, 40);
      EXPECT_NE(message.find("cut.ply"), std::string::npos) << message;
    }
  }
}

TEST(PlyBadData, TruncationNamesTheElementAndItsNumber) {
  const TemporaryFolder folder;
  const auto cut = [&](BodyFormat format, std::size_t by) {
    const std::string file = small_file(format, {{0, 1, 2}, {2, 1, 0}});
    return folder.write("cut.ply", file.substr(0, file.size() - by));
  };
  expect_bad(cut(BodyFormat::kLittle, 1), {"truncated in face 1", "3 items of 4 bytes", "found 11 bytes"});
}

TEST(PlyBadData, AnIndexOutOfRangeNamesTheFace) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    expect_bad(folder.write("i.ply", small_file(format, {{0, 1, 2}, {0, 1, 3}})),
               {"face 1", "vertex index 3 is out of range", "expected 0 to 2"});
    expect_bad(folder.write("i.ply", small_file(format, {{0, 1, 2}, {0, 1, 2}, {0, -1, 2}})),
               {"face 2", "index -1"});
    expect_bad(folder.write("i.ply", small_file(format, {{0, 1, 2}, {0, 200, 2}}, "uchar")),
               {"face 1", "index 200"});
    // Polygons take the sequential path; indices of faces that are skipped are checked too.
    expect_bad(folder.write("i.ply", small_file(format, {{0, 1, 2, 0}, {0, 1, 2, 7}})),
               {"face 1", "index 7"});
    expect_bad(folder.write("i.ply", small_file(format, {{0, 1, 2}, {9}})), {"face 1", "index 9"});
  }
}

TEST(PlyBadData, StripsRestartAtMinusOneOnly) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    PlyBody body(format);
    for (int i = 0; i < 3; ++i) body.put("float", i).put("float", 0).put("float", 0).end_row();
    body.list("int", "int", {0, 1, 2, -2}).end_row();
    expect_bad(
        folder.write("s.ply",
                     ply_header(format, fmt::format("element vertex 3\n{}element tristrips 1\nproperty list "
                                                    "int int vertex_indices\n",
                                                    kFloatVertex)) +
                         body.bytes()),
        {"tristrips 0", "index -2"});
  }
}

// Whether it is bad data only who knows all triangles can tell.
TEST(PlyBadData, CoordinatesThatAreNotFiniteAreRemarked) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    for (const double value : {kNan, kInfinity, -kInfinity}) {
      const auto path = folder.write("n.ply", small_file(format, {{0, 1, 2}}, "int", value));
      EXPECT_EQ(collect(path).noted.undefined_positions, (Tally{1, 2}));
      const std::string name = path.string();
      try {
        load_mesh(std::span(&name, 1));
        ADD_FAILURE() << "a triangle has a corner at " << value;
      } catch (const core::Error& error) {
        EXPECT_EQ(error.status(), core::Status::kBadData);
        EXPECT_NE(std::string(error.what())
                      .find(fmt::format("vertex 2: coordinate x is {}; expected a finite number", value)),
                  std::string::npos)
            << error.what();
      }
    }
  }
}

TEST(PlyBadData, ColoursThatAreNoNumbersAreMissing) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    PlyBody body(format);
    for (const double value : {0.0, 0.0, 0.0, 0.5, 0.5, 0.5}) body.put("float", value);
    body.end_row();
    for (const double value : {0.0, 0.0, 0.0, 0.5, kNan, 0.5}) body.put("float", value);
    body.end_row();
    const Collected read = collect(folder.write(
        "c.ply", ply_header(format, fmt::format("element vertex 2\n{}property float red\nproperty float "
                                                "green\nproperty float blue\n",
                                                kFloatVertex)) +
                     body.bytes()));
    EXPECT_EQ(read.colors, (std::vector<Color>{{128, 128, 128, 255}, kNoColor}));
    EXPECT_EQ(read.noted.undefined_colors, (Tally{1, 1}));
  }
}

TEST(PlyBadData, BytesBehindTheLastElementAreAnError) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    for (const auto& faces : {std::vector<std::vector<double>>{{0, 1, 2}}, {{0, 1, 2, 0}}, {}}) {
      const std::string file = small_file(format, faces);
      EXPECT_EQ(collect(folder.write("t.ply", file + " \n\r\n")).positions.size(), 3U);
      expect_bad(folder.write("t.ply", file + "7 "), {"expected", "end", "found"});
    }
  }
}

TEST(PlyBadData, CountsThatLieAreErrorsWithoutAllocation) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    const std::string file = small_file(format, {{0, 1, 2}});
    const auto with = [&](std::string_view from, std::string_view to) {
      std::string changed = file;
      changed.replace(changed.find(from), from.size(), to);
      return folder.write("lie.ply", changed);
    };
    for (const char* count : {"5", "1000", "4294967296", "9223372036854775808", "18446744073709551615"}) {
      bad_data_message(with("element vertex 3", fmt::format("element vertex {}", count)));
      bad_data_message(with("element face 1", fmt::format("element face {}", count)));
    }
    expect_bad(with("element vertex 3", "element vertex 9223372036854775808"),
               {"9223372036854775808 vertices", "at most 4294967295"});
    expect_bad(with("element vertex 3", "element vertex 4294967295"),
               {"truncated, or the header lies", "4294967295 rows of element vertex"});
    expect_bad(with("element vertex 3", "element vertex 18446744073709551616"), {"header line 3", "count"});
    expect_bad(with("element vertex 3", "element vertex -3"), {"header line 3", "count"});
    bad_data_message(with("element vertex 3", "element vertex 2"));
    bad_data_message(with("element face 1", "element face 0"));
  }
}

TEST(PlyBadData, AbsurdListCountsAreErrorsWithoutAllocation) {
  const TemporaryFolder folder;
  const std::string lines = fmt::format(
      "element vertex 3\n{}element face 1\nproperty list int int vertex_indices\nproperty list int int "
      "more\n",
      kFloatVertex);
  for (const BodyFormat format : kFormats) {
    for (const double count : {2147483647.0, -5.0}) {
      for (const bool in_second_list : {false, true}) {
        PlyBody body(format);
        for (int i = 0; i < 3; ++i) body.put("float", i).put("float", 0).put("float", 0).end_row();
        if (in_second_list) body.list("int", "int", {0, 1, 2});
        body.put("int", count).put("int", 0).put("int", 1).end_row();
        expect_bad(folder.write("l.ply", ply_header(format, lines) + body.bytes()),
                   {"face 0", count < 0 ? "has count -5; expected at least 0" : "truncated in face 0"});
      }
    }
  }
}

TEST(PlyBadData, TextRowsMustHaveTheirProperties) {
  const TemporaryFolder folder;
  const std::string header =
      ply_header(BodyFormat::kAscii, fmt::format("element vertex 2\n{}element face 1\nproperty list "
                                                 "uchar int vertex_indices\n",
                                                 kFloatVertex));
  expect_bad(folder.write("a.ply", header + "0 0 0 4\n1 1 1\n3 0 1 1\n"),
             {"vertex 0", "end of the line", "'4'"});
  expect_bad(folder.write("a.ply", header + "0 0\n1 1 1\n3 0 1 1\n"), {"vertex 0", "end of the line", "'1'"});
  expect_bad(folder.write("a.ply", header + "0 0 0\n1 y 1\n3 0 1 1\n"),
             {"vertex 1", "property y", "number", "'y'"});
  expect_bad(folder.write("a.ply", header + "0 0 0\n1 1 1\n3 0 1.5 1\n"), {"face 0", "integer", "'1.5'"});
  expect_bad(folder.write("a.ply", header + std::string(5000, '1') + " 0 0\n1 1 1\n3 0 1 1\n"),
             {"line 1", "word"});
}

TEST(PlyBadData, HeadersThatAreMalformedNameTheLine) {
  const TemporaryFolder folder;
  const std::string vertex = fmt::format("element vertex 1\n{}", kFloatVertex);
  const auto header = [&](const std::string& lines) {
    return folder.write("h.ply", "ply\n" + lines + "end_header\n0 0 0\n");
  };
  ASSERT_NO_THROW(collect(header("format ascii 1.0\n" + vertex)));
  expect_bad(header(vertex), {"header line 6", "format"});
  expect_bad(header("format ascii 2.0\n" + vertex), {"header line 2", "version 1.0", "'format ascii 2.0'"});
  expect_bad(header("format binary 1.0\n" + vertex), {"header line 2", "'format binary 1.0'"});
  expect_bad(header("format ascii 1.0\nformat ascii 1.0\n" + vertex), {"header line 3"});
  expect_bad(header("format ascii 1.0\nproperty float x\n" + vertex), {"header line 3", "element"});
  expect_bad(header("format ascii 1.0\n" + vertex + "property float x\n"),
             {"header line 7", "different names"});
  expect_bad(header("format ascii 1.0\n" + vertex + "element vertex 1\n"),
             {"header line 7", "different names"});
  expect_bad(header("format ascii 1.0\n" + vertex + "property quaternion q\n"), {"header line 7", "type"});
  expect_bad(header("format ascii 1.0\n" + vertex + "property list float int q\n"),
             {"header line 7", "integer type"});
  expect_bad(header("format ascii 1.0\n" + vertex + "properties float q\n"),
             {"header line 7", "'properties float q'"});
  expect_bad(header("format ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"),
             {"x, y and z"});
  expect_bad(
      header("format ascii 1.0\n" + vertex + "element face 1\nproperty list uchar float vertex_indices\n"),
      {"element face", "vertex_indices"});
  expect_bad(header("format ascii 1.0\nelement vertex 0\n" + std::string(kFloatVertex)), {"no vertices"});
  expect_bad(header("format ascii 1.0\n"), {"element vertex"});
  expect_bad(folder.write("h.ply", "ply\n" + std::string(3 << 20, 'x')), {"end_header"});
  expect_bad(folder.write("h.ply", "plyx\n"), {"header"});
}

}  // namespace
}  // namespace colossus::input
