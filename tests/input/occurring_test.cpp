// Inputs as they occur: colours of either scale, of vertices and of faces, padding, and what --lenient lets
// pass.
#include <cmath>

#include "input/load.hpp"
#include "support/input_testing.hpp"

namespace colossus::input {

using namespace support;
namespace {

using Colors = std::vector<Color>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;
using Positions = std::vector<std::array<double, 3>>;

constexpr SourceOptions kLenient{.is_lenient = true};
constexpr BodyFormat kFormats[] = {BodyFormat::kAscii, BodyFormat::kLittle, BodyFormat::kBig};

// A triangle with the given colours at its corners.
std::string colored_ply(BodyFormat format, std::string_view type,
                        const std::vector<std::array<double, 4>>& colors) {
  PlyBody body(format);
  for (std::size_t i = 0; i < colors.size(); ++i) {
    body.put("float", i == 1).put("float", i == 2).put("float", 0);
    for (const double value : colors[i]) body.put(type, value);
    body.end_row();
  }
  body.list("uchar", "int", {0, 1, 2}).end_row();
  std::string lines = fmt::format("element vertex {}\n{}", colors.size(), kFloatVertex);
  for (const char* name : {"red", "green", "blue", "alpha"})
    lines += fmt::format("property {} {}\n", type, name);
  return ply_header(format, lines + "element face 1\nproperty list uchar int vertex_indices\n") +
         body.bytes();
}

TEST(Colors, TheScaleOfFloatsIsFoundFromAllValues) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    const auto read = [&](double red, double alpha) {
      return collect(folder.write("c.ply", colored_ply(format, "float",
                                                       {{red, 0.5, 0, alpha}, {1, 0, 1, 1}, {0, 0, 1, 1}})))
          .colors[0];
    };
    EXPECT_EQ(read(1.0, 1.0), (Color{255, 128, 0, 255}));
    EXPECT_EQ(read(1.02, 0.5), (Color{255, 128, 0, 128})) << "exporters overshoot";
    EXPECT_EQ(read(1.03, 1.0), (Color{1, 1, 0, 255})) << "alpha has a scale of its own";
    EXPECT_EQ(read(255.0, 255.0), (Color{255, 1, 0, 255}));
    EXPECT_EQ(read(0.5, 200.0), (Color{128, 128, 0, 200}));
    EXPECT_EQ(read(-3.0, -1.0), (Color{0, 128, 0, 0}));
    for (const double beyond : {255.5, 65535.0, 1e300}) {
      expect_bad(folder.write("c.ply", colored_ply(format, "double", {{beyond, 0, 0, 1}, {}, {}})),
                 {"the greatest colour"});
      expect_bad(folder.write("c.ply", colored_ply(format, "double", {{1, 0, 0, beyond}, {}, {}})),
                 {"alpha of a colour"});
    }
  }
}

TEST(Colors, IntegersKeepTheScaleOfTheirType) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats) {
    const auto read = [&](std::string_view type, double value) {
      return collect(folder.write("c.ply", colored_ply(format, type, {{value, 0, 0, 1}, {}, {}}))).colors[0];
    };
    EXPECT_EQ(read("uchar", 1), (Color{1, 0, 0, 1}));
    EXPECT_EQ(read("ushort", 257 * 7), (Color{7, 0, 0, 0}));
    EXPECT_EQ(read("int", 300), (Color{255, 0, 0, 1}));
  }
}

TEST(Colors, NamesMayBeInCapitals) {
  const TemporaryFolder folder;
  std::string file = colored_ply(BodyFormat::kAscii, "uchar", {{1, 2, 3, 4}, {}, {}});
  for (const char* name : {"red", "green", "blue"}) {
    std::string capitals = name;
    for (char& c : capitals) c = static_cast<char>(std::toupper(c));
    file.replace(file.find(name), capitals.size(), capitals);
  }
  EXPECT_EQ(collect(folder.write("c.ply", file)).colors[0], (Color{1, 2, 3, 4}));
}

std::string face_colored_ply(BodyFormat format, std::string_view type,
                             const std::vector<std::vector<double>>& faces, bool color_first) {
  PlyBody body(format);
  for (int i = 0; i < 5; ++i) body.put("float", i).put("float", i * i).put("float", 0).end_row();
  double shade = 0;
  for (const auto& face : faces) {
    const auto put_color = [&] { body.put(type, shade).put(type, 1).put(type, 0); };
    if (color_first) put_color();
    body.list("uchar", "int", face);
    if (!color_first) put_color();
    body.end_row();
    shade += 0.25;
  }
  std::string color;
  for (const char* name : {"red", "green", "blue"}) color += fmt::format("property {} {}\n", type, name);
  const std::string list = "property list uchar int vertex_indices\n";
  return ply_header(format, fmt::format("element vertex 5\n{}element face {}\n{}", kFloatVertex, faces.size(),
                                        color_first ? color + list : list + color)) +
         body.bytes();
}

TEST(Colors, OfFacesGoWithTheirTriangles) {
  const TemporaryFolder folder;
  for (const BodyFormat format : kFormats)
    for (const bool color_first : {true, false}) {
      const auto path = folder.write(
          "f.ply", face_colored_ply(format, "float", {{0, 1, 2}, {1, 2, 3}, {2, 3, 4}}, color_first));
      EXPECT_EQ(collect(path).face_colors, (Colors{{0, 255, 0, 255}, {64, 255, 0, 255}, {128, 255, 0, 255}}));
      EXPECT_TRUE(open_source(path)->info().has_face_colors);
      const auto odd = folder.write(
          "p.ply", face_colored_ply(format, "float", {{0, 1, 2, 3}, {0, 1}, {2, 3, 4}}, color_first));
      const Collected read = collect(odd);
      EXPECT_EQ(read.face_colors, (Colors{{0, 255, 0, 255}, {0, 255, 0, 255}, {128, 255, 0, 255}}));
      EXPECT_EQ(read.polygons, (std::vector<std::array<std::uint64_t, 2>>{{0, 4}}));
    }
}

TEST(Colors, OfFacesAreSkippedWhereVerticesHaveSome) {
  const TemporaryFolder folder;
  const auto source = open_source(folder.write(
      "c.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar "
      "blue\nend_header\n0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2 9 9 9\n"));
  EXPECT_EQ(source->info().skipped, (std::vector<std::string>{"face.red", "face.green", "face.blue"}));
  EXPECT_EQ(collect(*source).colors, (Colors(3, {1, 2, 3, 255})));
  const auto off = open_source(
      folder.write("c.off", "COFF\n3 1 0\n0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2 9 9 9\n"));
  const Collected read = collect(*off);
  EXPECT_EQ(read.noted.unread_colors, 1U);
  EXPECT_TRUE(read.face_colors.empty());
}

std::string stl_with_attributes(const std::vector<std::uint16_t>& attributes, std::string header = "solid") {
  header.resize(80);
  const auto count = static_cast<std::uint32_t>(attributes.size());
  header.append(reinterpret_cast<const char*>(&count), 4);
  for (const std::uint16_t attribute : attributes) {
    const std::array<float, 12> row{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    header.append(reinterpret_cast<const char*>(&row), sizeof(row));
    header.append(reinterpret_cast<const char*>(&attribute), 2);
  }
  return header;
}

TEST(Colors, OfStlAreThoseOfVisCamOrOfMagics) {
  const TemporaryFolder folder;
  const std::uint16_t red_high = 0x8000 | 31 << 10, gray = 0x8000 | 16 << 10 | 16 << 5 | 16;
  const Collected viscam = collect(folder.write("v.stl", stl_with_attributes({red_high, gray, 31, 0})));
  const Color mid{132, 132, 132, 255};
  EXPECT_EQ(viscam.colors, (Colors{{255, 0, 0, 255},
                                   {255, 0, 0, 255},
                                   {255, 0, 0, 255},
                                   mid,
                                   mid,
                                   mid,
                                   kNoColor,
                                   kNoColor,
                                   kNoColor,
                                   kNoColor,
                                   kNoColor,
                                   kNoColor}));
  EXPECT_EQ(viscam.noted.missing_colors, (Tally{2, 2}));
  EXPECT_EQ(viscam.noted.attribute_bytes, 1U);
  const Collected magics = collect(
      folder.write("m.stl", stl_with_attributes({31, 0x8000, 0}, "COLOR=\x01\x02\x03\xFF,MATERIAL=")));
  EXPECT_EQ(magics.colors[0], (Color{255, 0, 0, 255}));
  EXPECT_EQ(magics.colors[3], (Color{1, 2, 3, 255}));
  EXPECT_EQ(magics.colors[6], (Color{1, 2, 3, 255}));
  EXPECT_TRUE(collect(folder.write("n.stl", stl_with_attributes({0, 7}))).colors.empty());
}

TEST(Colors, OfOffRowsNeedNoKeyword) {
  const TemporaryFolder folder;
  const Collected plain =
      collect(folder.write("p.off", "OFF\n3 1 0\n0 0 0 9 8 7\n1 0 0 9 8 7\n0 1 0 9 8 7\n3 0 1 2\n"));
  EXPECT_EQ(plain.colors, (Colors(3, {9, 8, 7, 255})));
  const Collected alpha =
      collect(folder.write("p.off", "OFF\n3 1 0\n0 0 0 9 8 7 6\n1 0 0 9 8 7 6\n0 1 0 9 8 7 6\n3 0 1 2\n"));
  EXPECT_EQ(alpha.colors, (Colors(3, {9, 8, 7, 6})));
  const auto other = open_source(folder.write("p.off", "OFF\n3 1 0\n0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2\n"));
  EXPECT_EQ(other->info().skipped, (std::vector<std::string>{"1 more numbers per vertex"}));
  EXPECT_EQ(collect(*other).positions[1], (std::array<double, 3>{1, 0, 0}));
  const Collected faces = collect(
      folder.write("f.off", "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2 3\n3 0 1 2 0.5 1 0\n"));
  EXPECT_EQ(faces.face_colors, (Colors{kNoColor, kNoColor, {128, 255, 0, 255}}));
  EXPECT_EQ(faces.noted.missing_colors, (Tally{2, 0}));
  EXPECT_EQ(faces.noted.color_indices, 1U);
}

TEST(Off, WhiteSpaceIsFree) {
  const TemporaryFolder folder;
  const Positions expected{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Triangles faces{{0, 1, 2}, {0, 2, 3}};
  for (const char* text : {"OFF\n4 2 0\n0 0 0 1 0 0\n0 1 0 0 0 1\n3 0 1 2\n3 0 2 3\n",
                           "OFF 4 2 0 0 0 0 1 0 0 0 1 0 0 0 1\n3 0 1 2\n3 0 2 3\n",
                           "OFF\n4\n2\n0\n0\n0\n0\n1\n0\n0\n0\n1\n0\n0\n0\n1\n3\n0\n1\n2\n3\n0\n2\n3\n",
                           "OFF\n4 2\n0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1\n2\n3 0 2 3",
                           "OFF\n4 2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 2 3\n"}) {
    SCOPED_TRACE(text);
    const Collected read = collect(folder.write("w.off", text));
    EXPECT_EQ(read.positions, expected);
    EXPECT_EQ(read.faces, faces);
  }
}

TEST(Off, ColouredVerticesMayBeWrappedAnyhow) {
  const TemporaryFolder folder;
  const Positions positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<std::string> words{"0",   "0",  "0",   "10", "20",  "30", "255", "1",  "0",
                                       "0",   "11", "21",  "31", "255", "0",  "1",   "0",  "12",
                                       "22",  "32", "255", "0",  "0",   "1",  "13",  "23", "33",
                                       "255", "3",  "0",   "1",  "2",   "3",  "0",   "2",  "3"};
  for (std::size_t width = 1; width <= 40; ++width) {
    std::string text = "COFF 4 2 0\n";
    for (std::size_t i = 0; i < words.size(); ++i) text += words[i] + ((i + 1) % width == 0 ? "\n" : " ");
    const Collected read = collect(folder.write("w.off", text));
    EXPECT_EQ(read.positions, positions) << width;
    EXPECT_EQ(read.colors,
              (Colors{{10, 20, 30, 255}, {11, 21, 31, 255}, {12, 22, 32, 255}, {13, 23, 33, 255}}))
        << width;
    EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}, {0, 2, 3}})) << width;
  }
}

TEST(Off, KeywordsMayStandInAnyOrder) {
  const TemporaryFolder folder;
  const std::string faces = "3 0 1 2\n";
  const auto rows = [](const std::string& rest) {
    return "0 0 0 " + rest + "\n1 0 0 " + rest + "\n0 1 0 " + rest + "\n";
  };
  for (const auto& [keyword, rest] :
       {std::pair{"CNOFF", "0 0 1 9 8 7 6"}, {"NCOFF", "9 8 7 6 0 0 1"}, {"noff", "0 0 1"}}) {
    const Collected read =
        collect(folder.write("k.off", std::string(keyword) + "\n3 1 0\n" + rows(rest) + faces));
    EXPECT_EQ(read.normals, (std::vector<std::array<float, 3>>(3, {0, 0, 1}))) << keyword;
    if (keyword[0] != 'n') {
      EXPECT_EQ(read.colors, Colors(3, {9, 8, 7, 6})) << keyword;
    }
  }
  expect_bad(folder.write("k.off", "CCOFF\n3 1 0\n" + rows("1") + faces), {"'CCOFF'"});
}

// What begins like nothing known ends the data only if nothing known follows.
TEST(Obj, OddLinesEndTheDataOnlyAtTheEnd) {
  const TemporaryFolder folder;
  const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
  for (const std::string& odd :
       {std::string("\xc3\x9c"
                    "bung 3\n"),
        std::string("\xfc"
                    "ber\n"),
        std::string("\0\n", 2),
        std::string("\x01 ") + std::string(5000, 'x') + "\n" + std::string(3000, '\xff') + "\n"})
    for (const SourceOptions& options : {SourceOptions{}, kLenient}) {
      const auto source = open_source(
          folder.write("o.obj", odd + start + odd + "vn 0 1 0\nv 0 0 1\n" + odd + "f 1//1 3//1 4//2\n"),
          options);
      const Collected read = collect(*source);
      EXPECT_EQ(read.positions.size(), 4U);
      EXPECT_EQ(read.faces.size(), 2U);
      EXPECT_EQ(read.normals[3], (std::array<float, 3>{0, 1, 0}));
      EXPECT_EQ(read.noted.trailing_bytes, 0U);
      EXPECT_FALSE(source->info().skipped.empty());
    }
  for (const char* end : {"f 1 2 3 \\", "f 1 2 3\\", "f 1 2 3 \\  "})
    EXPECT_EQ(collect(folder.write("o.obj", start + end)).faces.size(), 2U) << "goes on where the file ends";
}

TEST(Colors, AnAlphaThatIsNoNumberIsMissing) {
  const TemporaryFolder folder;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const BodyFormat format : kFormats) {
    const Collected read =
        collect(folder.write("a.ply", colored_ply(format, "float", {{1, 0.5, 0, nan}, {0, 0, 0, 0}, {}})));
    EXPECT_EQ(read.colors[0], (Color{255, 128, 0, 255}));
    EXPECT_EQ(read.noted.undefined_alphas, (Tally{1, 0}));
    EXPECT_EQ(read.noted.undefined_colors.count, 0U);
  }
}

// However a file is read, what is remarked is the same.
TEST(Colors, OfFacesThatAreNoNumbersAreMissingInEveryReader) {
  const TemporaryFolder folder;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const BodyFormat format : kFormats)
    for (const bool has_quad : {false, true}) {
      PlyBody body(format);
      for (int i = 0; i < 4; ++i) body.put("float", i & 1).put("float", i / 2).put("float", 0).end_row();
      body.list("uchar", "int", {0, 1, 2}).put("float", nan).put("float", 0).put("float", 1).end_row();
      if (has_quad)
        body.list("uchar", "int", {0, 1, 3, 2}).put("float", nan).put("float", 0).put("float", 1).end_row();
      const Collected read = collect(folder.write(
          "n.ply",
          ply_header(format, fmt::format("element vertex 4\n{}element face {}\nproperty list uchar int "
                                         "vertex_indices\nproperty float red\nproperty float green\nproperty "
                                         "float blue\n",
                                         kFloatVertex, has_quad ? 2 : 1)) +
              body.bytes()));
      EXPECT_EQ(read.noted.undefined_colors, (Tally{has_quad ? 2U : 1U, 0}));
      EXPECT_EQ(read.noted.missing_colors.count, 0U);
      EXPECT_EQ(read.face_colors, Colors(has_quad ? 3 : 1, kNoColor));
    }
}

// The guess that all faces are triangles may find what looks like padding.
TEST(Tail, LastNumbersOfAQuadAreNoPadding) {
  const TemporaryFolder folder;
  PlyBody body(BodyFormat::kLittle);
  for (int i = 0; i < 5; ++i) body.put("float", i).put("float", i * i).put("float", 0);
  body.list("uchar", "int", {3, 2, 1, 0});
  for (int i = 0; i < 5; ++i) body.list("uchar", "int", {3, 4, 0});
  const auto source = open_source(folder.write(
      "q.ply",
      ply_header(BodyFormat::kLittle,
                 fmt::format("element vertex 5\n{}element face 6\nproperty list uchar int vertex_indices\n",
                             kFloatVertex)) +
          body.bytes()));
  const Collected read = collect(*source);
  EXPECT_EQ(read.faces.size(), 7U);
  EXPECT_TRUE(warnings_of(source->info(), read.noted).empty());
}

// A word that is missing is not made good by the next row, however lenient.
TEST(Lenient, DoesNotTakeARowForTheRestOfAnother) {
  const TemporaryFolder folder;
  const std::string header =
      ply_header(BodyFormat::kAscii,
                 fmt::format("element vertex 3\n{}element face 1\nproperty list uchar int vertex_indices\n",
                             kFloatVertex));
  expect_bad(folder.write("s.ply", header + "0 0 0\n1 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"), {"vertex 1"}, kLenient);
}

TEST(Obj, WeightsDivide) {
  const TemporaryFolder folder;
  const Collected read = collect(folder.write("w.obj", "v 2 4 6 2\nv 1 2 3 0\nv 1 1 1 1\nf 1 2 3\n"));
  EXPECT_EQ(read.positions[0], (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(read.noted.undefined_positions, (Tally{1, 1}));
}

TEST(Obj, BlanksMayFollowABackslash) {
  const TemporaryFolder folder;
  const std::string blanks(5000, ' ');
  for (const std::string& gap : {std::string("\\\n"), std::string("\\ \t\r\n"), "\\" + blanks + "\n"}) {
    const Collected read =
        collect(folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 " + gap + "0\n# \\\nf 1 " + gap +
                                          " 2 3\ng x " + gap + "f 1 1 1\nf 1 2 3\n"));
    EXPECT_EQ(read.positions.size(), 3U);
    EXPECT_EQ(read.faces.size(), 2U) << "what is continued is no statement";
  }
}

TEST(TextReader, NumbersOfWindowsAreNumbers) {
  const TemporaryFolder folder;
  for (const char* word : {"-1.#IND", "1.#QNAN", "1.#IND000", "-1.#QNAN0", "1.#SNAN", "1.#INF", "-1.#INF00",
                           "nan", "-nan(ind)"}) {
    const std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex 1\n{}property float nx\nproperty float ny\n"
        "property float nz\nend_header\n1 2 3 0 {} 0\n",
        kFloatVertex, word);
    EXPECT_EQ(collect(folder.write("w.ply", text)).noted.undefined_normals, (Tally{1, 0})) << word;
  }
  for (const char* word : {"1.#", "1.#ABC", "2.#IND", "1.#IND.", "1,5", "#IND"})
    expect_bad(folder.write("w.obj", fmt::format("v 1 2 3\nv 1 2 x{}\n", word)), {"vertex 1", "number"});
}

// The same mesh in every format that has an end.
std::vector<std::pair<std::string, std::string>> whole_files() {
  const std::vector<std::array<double, 4>> colors(3, {1, 2, 3, 4});
  return {{"a.ply", colored_ply(BodyFormat::kAscii, "uchar", colors)},
          {"l.ply", colored_ply(BodyFormat::kLittle, "uchar", colors)},
          {"b.ply", colored_ply(BodyFormat::kBig, "uchar", colors)},
          {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
          {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"}};
}

TEST(Tail, ZerosAndWhiteSpaceAreRemarked) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : whole_files())
    for (const std::string& tail :
         {std::string(1, '\0'), std::string(5000, '\0'), std::string("\x1a\0\0 \n\0", 6)}) {
      const auto source = open_source(folder.write(name, text + tail));
      const Collected read = collect(*source);
      EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}})) << name;
      EXPECT_EQ(warnings_of(source->info(), read.noted).size(), 1U) << name;
    }
}

// Also where no line end is between the last word, or a backslash that would continue it, and the zeros.
TEST(Tail, ZerosMayTouchTheLastWord) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : whole_files()) {
    if (name.front() != 'a') continue;
    const std::string trimmed = text.substr(0, text.find_last_not_of('\n') + 1);
    for (const char* end : {"", "\\", "\\ "}) {
      if (*end != '\0' && name != "a.obj") continue;
      const Collected read = collect(folder.write(name, trimmed + end + std::string(5000, '\0')));
      EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}})) << name << end;
      EXPECT_EQ(read.noted.trailing_padding, 5000U + std::string_view(end).ends_with(' ')) << name << end;
    }
  }
}

TEST(Tail, OtherBytesPassOnlyIfLenient) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : whole_files())
    for (const std::string& tail :
         {std::string("\x01garbage"), std::string("\0\0\0\x80 w 1 2 3\n", 12), std::string(5000, '\xff')}) {
      const auto path = folder.write(name, text + tail);
      expect_bad(path, {"--lenient"});
      const auto source = open_source(path, kLenient);
      const Collected read = collect(*source);
      EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}})) << name;
      EXPECT_GE(read.noted.trailing_bytes, tail.size() - 3) << name;
      EXPECT_EQ(warnings_of(source->info(), read.noted).size(), 1U) << name;
    }
}

// A hole of zeros within the data is no padding.
TEST(Tail, ZerosBetweenDataAreBad) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : whole_files()) {
    if (name.front() != 'a') continue;
    std::string holed = text;
    holed.insert(text.size() - 4, 3, '\0');
    EXPECT_FALSE(bad_data_message(folder.write(name, holed)).empty());
  }
}

TEST(Lenient, LetsFloatIndicesPass) {
  const TemporaryFolder folder;
  const std::pair<const char*, std::string> files[] = {
      {"a.ply", ply_header(BodyFormat::kAscii,
                           fmt::format("element vertex 3\n{}element face 1\nproperty list uchar int "
                                       "vertex_indices\n",
                                       kFloatVertex)) +
                    "0 0 0\n1 0 0\n0 1 0\n3.0 0.0 1.0 2e0\n"},
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1.0 2.0/5.0 3\n"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3.0 0 1.0 2\n"}};
  for (const auto& [name, text] : files) {
    const auto path = folder.write(name, text);
    expect_bad(path, {"face 0"});
    const Collected read = collect(path, kLenient);
    EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}})) << name;
    EXPECT_EQ(read.noted.float_indices, (Tally{1, 0})) << name;
    std::string half = text;
    half.replace(half.rfind(name[2] == 'o' && name[3] == 'b' ? "2.0" : "1.0"), 3, "1.5");
    expect_bad(folder.write(name, half), {"face 0"}, kLenient);
  }
  PlyBody body(BodyFormat::kLittle);
  for (int i = 0; i < 3; ++i) body.put("float", i == 1).put("float", i == 2).put("float", 0);
  body.list("uchar", "float", {0, 1, 2});
  const auto path = folder.write(
      "b.ply", ply_header(BodyFormat::kLittle,
                          fmt::format("element vertex 3\n{}element face 1\nproperty list uchar float "
                                      "vertex_indices\n",
                                      kFloatVertex)) +
                   body.bytes());
  expect_bad(path, {"integer list vertex_indices", "--lenient"});
  EXPECT_EQ(collect(path, kLenient).faces, (Triangles{{0, 1, 2}}));
}

TEST(Lenient, LetsSurplusNumbersPass) {
  const TemporaryFolder folder;
  const std::string header =
      ply_header(BodyFormat::kAscii,
                 fmt::format("element vertex 3\n{}element face 1\nproperty list uchar int vertex_indices\n",
                             kFloatVertex));
  const std::pair<const char*, std::string> files[] = {
      {"a.ply", header + "0 0 0\n1 0 0 7\n0 1 0\n3 0 1 2 9 9\n"},
      {"a.obj", "v 0 0 0\nv 1 0 0 4 5\nv 0 1 0\nf 1 2 3\n"},
      {"b.obj", "v 0 0 0\nv 1 0 0 1 1 1 1 1\nv 0 1 0\nf 1 2 3\n"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0 4\n0 1 0\n3 0 1 2 1 2\n"}};
  for (const auto& [name, text] : files) {
    const auto path = folder.write(name, text);
    expect_bad(path, {"vertex 1"});
    const Collected read = collect(path, kLenient);
    EXPECT_EQ(read.positions, (Positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})) << name;
    EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}})) << name;
    EXPECT_EQ(read.noted.surplus_in_vertices, (Tally{1, 1})) << name;
  }
  expect_bad(folder.write("a.ply", header + "0 0 0\n1 0 0 x\n0 1 0\n3 0 1 2\n"), {"vertex 1"}, kLenient);
}

TEST(Lenient, LetsProseInHeadersPass) {
  const TemporaryFolder folder;
  std::string ply = colored_ply(BodyFormat::kLittle, "uchar", std::vector<std::array<double, 4>>(3));
  ply.insert(ply.find("element"), "Made by somebody, with care:\n");
  const std::string off = "OFF\nMade by somebody\nwith care\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (const auto& [name, text] : {std::pair{"p.ply", ply}, {"p.off", off}}) {
    const auto path = folder.write(name, text);
    expect_bad(path, {"header"});
    const auto source = open_source(path, kLenient);
    EXPECT_EQ(source->info().passed.size(), 1U);
    EXPECT_EQ(collect(*source).faces, (Triangles{{0, 1, 2}}));
  }
}

TEST(Detection, ContentDecides) {
  const TemporaryFolder folder;
  const std::string ascii =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid\n";
  const std::string binary = stl_with_attributes({0}, "solid of a kind");
  for (const char* name : {"a.stl", "a.STL", "a.txt", "a.ply", "a.obj", "a.off", "a"}) {
    for (const std::string& start :
         {std::string("solid\n"), std::string("\n \tSOLID x\r\n"), std::string("\xEF\xBB\xBFSolid\n"),
          std::string("solid_\x1b[0m\n"), std::string("# made\nsolid\n"),
          "solid " + std::string(3000, '/') + "\n"})
      EXPECT_EQ(collect(folder.write(name, start + ascii)).faces.size(), 1U) << name << start;
    for (const std::string& tail :
         {std::string(), std::string("\n"), std::string(49, 'x'), std::string(5000, '\0')}) {
      const auto source = open_source(folder.write(name, binary + tail));
      EXPECT_EQ(source->info().format, "STL binary");
      EXPECT_EQ(source->info().passed.size(), tail.empty() ? 0U : 1U);
    }
    const auto padded =
        open_source(folder.write(name, stl_with_attributes({0}, "a kind") + std::string(5000, '\0')));
    EXPECT_EQ(padded->info().format, "STL binary");
    EXPECT_EQ(open_source(folder.write(name, "OFF 1 0 0\n0 0 0\n"))->info().format, "OFF");
    EXPECT_EQ(open_source(folder.write(name, "v 0 0 0\n"))->info().format, "OBJ");
  }
}

TEST(Detection, NamesWhatIsNoMesh) {
  const TemporaryFolder folder;
  using namespace std::string_literals;
  const std::pair<std::string, const char*> files[] = {
      {"\x1f\x8b\x08"s, "gzip"},
      {"PK\x03\x04..", "zip"},
      {"BZh91AY", "bzip2"},
      {"\xFD"
       "7zXZ\0"s,
       "xz"},
      {"\x28\xB5\x2F\xFD..", "zstd"},
      {"\xFF\xFEp\0l\0y\0"s, "UTF-16"},
      {"\xFE\xFF\0p\0l\0y"s, "UTF-16"},
      {"p\0l\0y\0\n\0f\0"s, "UTF-16"},
      {"\0p\0l\0y\0\n"s, "UTF-16"},
      {"version https://git-lfs.github.com/spec/v1\n", "version https://git-lfs"},
      {"  <!DOCTYPE html>\n", "HTML"},
      {"\x89HDF\r\n\x1a\n", "HDF5"}};
  for (const auto& [bytes, word] : files)
    for (const char* name : {"x.ply", "x.obj", "x.stl", "x.off", "x"})
      expect_bad(folder.write(name, bytes), {word});
}

TEST(Load, PolygonsAndColoursOfFaces) {
  const TemporaryFolder folder;
  // An arrow head: the fan from its first corner would reach outside.
  const std::string arrow =
      folder.write("a.off", "OFF\n4 1 0\n0 0 0\n4 4 0\n0 1 0\n-4 4 0\n4 1 2 3 0 1 0 0\n").string();
  const LoadedMesh mesh = load_mesh(std::span(&arrow, 1));
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const auto& [a, b, c] = std::tie(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    area += std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
  }
  EXPECT_EQ(area, 4.0);
  EXPECT_EQ(mesh.colors, Colors(4, {255, 0, 0, 255}));
}

TEST(Source, CanBeClosedBetweenParts) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : whole_files()) {
    const auto source = open_source(folder.write(name, text));
    source->close();
    EXPECT_EQ(collect(*source).faces, (Triangles{{0, 1, 2}})) << name;
    source->close();
    folder.write(name, text + "\n");
    EXPECT_THROW(collect(*source), core::Error) << "it has another size";
  }
}

}  // namespace
}  // namespace colossus::input
