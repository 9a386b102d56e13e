// PLY in all its variants: what comes back is what was written.
#include <iostream>
#include <random>

#include "support/input_testing.hpp"

namespace colossus::input {

using namespace support;
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// A random mesh and a random way of writing it.
class RandomPly {
 public:
  RandomPly(std::uint64_t seed, std::size_t vertex_count, std::size_t face_count) : random_(seed) {
    format_ = static_cast<BodyFormat>(pick(3));
    only_triangles_ = pick(2) == 0;
    choose_vertex_properties();
    const bool vertices_first = pick(3) > 0;
    if (pick(3) == 0) add_unknown("before");
    vertices_first ? add_vertices(vertex_count) : add_faces(vertex_count, face_count);
    if (pick(3) == 0) add_unknown("between");
    vertices_first ? add_faces(vertex_count, face_count) : add_vertices(vertex_count);
    if (pick(3) == 0) add_unknown("after");
  }

  std::string bytes() const { return text_header() + body_; }
  BodyFormat format() const { return format_; }

  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::array<std::uint8_t, 4>> colors;
  Triangles triangles;
  Remarks odd;
  std::vector<std::string> skipped;

 private:
  struct Property {
    std::string name, type, count_type;
    int slot = -1;
  };

  std::size_t pick(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
  std::string one_of(const std::vector<std::string>& names) { return names[pick(names.size())]; }

  std::string text_header() const {
    const std::string text =
        fmt::format("ply\nformat {} 1.0\ncomment made by a test\nobj_info number 1\n{}end_header\n",
                    format_name(format_), header_);
    if (!crlf_) return text;
    std::string result;
    for (const char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
    return result;
  }

  void choose_vertex_properties() {
    crlf_ = pick(3) == 0;
    const std::vector<std::string> floats = {"float", "double", "float32", "float64"};
    const std::string position_type =
        pick(5) == 0 ? one_of({"short", "int", "char", "uint8"}) : one_of(floats);
    for (int i = 0; i < 3; ++i) properties_.push_back({std::string(1, "xyz"[i]), position_type, "", i});
    if (pick(2) == 0) {
      const std::string type = one_of(floats);
      for (int i = 0; i < 3; ++i) properties_.push_back({fmt::format("n{}", "xyz"[i]), type, "", 3 + i});
    }
    if (pick(2) == 0) {
      const std::string prefix = one_of({"", "diffuse_"});
      const bool is_short = prefix.empty() && pick(3) == 0;
      const std::string type = one_of({"uchar", "uint8", "float", "double", "ushort", "int"});
      has_alpha_ = pick(2) == 0;
      const std::vector<std::string> names = is_short
                                                 ? std::vector<std::string>{"r", "g", "b", "a"}
                                                 : std::vector<std::string>{"red", "green", "blue", "alpha"};
      for (std::size_t i = 0; i < (has_alpha_ ? 4 : 3); ++i)
        properties_.push_back({prefix + names[i], type, "", 6 + static_cast<int>(i)});
    }
    if (pick(3) == 0) properties_.push_back({"quality", one_of({"float", "int16", "uint32"}), "", -1});
    if (pick(4) == 0) properties_.push_back({"history", "double", one_of({"uchar", "short"}), -1});
    std::shuffle(properties_.begin(), properties_.end(), random_);
    for (const Property& property : properties_)
      if (property.slot < 0) skipped.push_back("vertex." + property.name);
  }

  // A value that the type can hold, so that it must come back exactly.
  double random_value(const std::string& type) {
    if (type == "double" || type == "float64")
      return (static_cast<double>(random_() >> 11) - 4503599627370496.0) / 1e9;
    if (type == "float" || type == "float32")
      return static_cast<float>(static_cast<double>(random_()) / 1e15 - 9000);
    return static_cast<double>(pick(120));
  }

  double color_value(const std::string& type, std::uint8_t color) {
    if (type == "float") return static_cast<float>(color) / 255.0F;
    if (type == "double") return color / 255.0;
    return type == "ushort" ? color * 257.0 : color;
  }

  void add_vertices(std::size_t count) {
    header_ += fmt::format("element vertex {}\n", count);
    for (const Property& property : properties_)
      header_ += property.count_type.empty() ? fmt::format("property {} {}\n", property.type, property.name)
                                             : fmt::format("property list {} {} {}\n", property.count_type,
                                                           property.type, property.name);
    PlyBody body(format_);
    for (std::size_t row = 0; row < count; ++row) {
      std::array<double, 3> position{};
      std::array<float, 3> normal{};
      std::array<std::uint8_t, 4> color{0, 0, 0, 255};
      for (const Property& property : properties_) {
        if (!property.count_type.empty()) {
          body.list(property.count_type, property.type, std::vector<double>(pick(4), 0.5));
        } else if (property.slot < 0) {
          body.put(property.type, 7);
        } else if (property.slot >= 6) {
          color[property.slot - 6] = static_cast<std::uint8_t>(pick(256));
          body.put(property.type, color_value(property.type, color[property.slot - 6]));
        } else {
          const double value = random_value(property.type);
          body.put(property.type, value);
          if (property.slot < 3) position[property.slot] = value;
          if (property.slot >= 3) normal[property.slot - 3] = static_cast<float>(value);
        }
      }
      body.end_row(crlf_ ? "\r\n" : "\n");
      positions.push_back(position);
      const auto has = [&](int slot) {
        return std::any_of(properties_.begin(), properties_.end(),
                           [&](const Property& p) { return p.slot == slot; });
      };
      if (has(3)) normals.push_back(normal);
      if (has(6)) colors.push_back(color);
    }
    body_ += body.bytes();
  }

  void add_faces(std::size_t vertex_count, std::size_t count) {
    std::vector<std::string> index_types = {"int", "uint", "int32", "uint32", "short", "uint16"};
    if (vertex_count > 30000) index_types.resize(4);
    if (vertex_count <= 100) index_types.insert(index_types.end(), {"uchar", "char", "int8"});
    const std::string index_type = one_of(index_types);
    const std::string count_type =
        one_of({"uchar", "char", "uint8", "short", "ushort", "int", "uint", "uint32"});
    const std::string flag = pick(3) == 0 ? "before" : pick(2) == 0 ? "after" : "";
    const bool extra_list = !only_triangles_ && pick(3) == 0;
    header_ += fmt::format("element face {}\n", count);
    if (extra_list) header_ += "property list uchar float weights\n", skipped.push_back("face.weights");
    if (flag == "before") header_ += "property uchar flag\n";
    header_ += fmt::format("property list {} {} {}\n", count_type, index_type,
                           one_of({"vertex_indices", "vertex_index"}));
    if (flag == "after") header_ += "property uchar flag\n";
    if (!flag.empty()) skipped.push_back("face.flag");
    PlyBody body(format_);
    for (std::size_t row = 0; row < count; ++row) {
      const std::size_t corners = only_triangles_ ? 3 : pick(7);
      std::vector<double> indices;
      for (std::size_t i = 0; i < corners; ++i) indices.push_back(static_cast<double>(pick(vertex_count)));
      const auto corner = [&](std::size_t i) { return static_cast<std::uint32_t>(indices[i]); };
      for (std::size_t i = 2; i < corners; ++i) triangles.push_back({corner(0), corner(i - 1), corner(i)});
      odd.polygons += corners > 3;
      odd.small += corners < 3;
      if (extra_list) body.list("uchar", "float", {1, 2});
      if (flag == "before") body.put("uchar", 1);
      body.list(count_type, index_type, indices);
      if (flag == "after") body.put("uchar", 1);
      body.end_row(crlf_ ? "\r\n" : "\n");
    }
    body_ += body.bytes();
  }

  void add_unknown(const std::string& name) {
    const std::size_t count = pick(4);
    const bool has_list = pick(2) == 0;
    header_ += fmt::format("element {} {}\nproperty int a\n{}", name, count,
                           has_list ? "property list int int b\n" : "");
    PlyBody body(format_);
    for (std::size_t row = 0; row < count; ++row) {
      body.put("int", 5);
      if (has_list) body.list("int", "int", std::vector<double>(pick(5), 3));
      body.end_row();
    }
    body_ += body.bytes();
    skipped.push_back("element " + name);
  }

  std::mt19937_64 random_;
  BodyFormat format_ = BodyFormat::kAscii;
  bool only_triangles_ = true;
  bool crlf_ = false;
  bool has_alpha_ = false;
  std::vector<Property> properties_;
  std::string header_;
  std::string body_;
};

void expect_reads_back(const TemporaryFolder& folder, const RandomPly& ply) {
  const auto source = open_source(folder.write("random.ply", ply.bytes()));
  const Collected read = collect(*source);
  EXPECT_EQ(read.positions, ply.positions);
  EXPECT_EQ(read.normals, ply.normals);
  EXPECT_EQ(read.colors, ply.colors);
  EXPECT_EQ(read.faces, ply.triangles);
  EXPECT_EQ(read.noted.polygons, ply.odd.polygons);
  EXPECT_EQ(read.noted.small, ply.odd.small);
  std::vector<std::string> expected = ply.skipped;
  expected.push_back("obj_info");
  std::vector<std::string> skipped = source->info().skipped;
  std::sort(expected.begin(), expected.end());
  std::sort(skipped.begin(), skipped.end());
  EXPECT_EQ(skipped, expected);
}

TEST(Ply, ReadsBackRandomMeshesInRandomVariants) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 1; seed <= 600 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    expect_reads_back(folder, RandomPly(seed, 1 + seed % 60, seed % 80));
  }
}

TEST(Ply, ReadsBackMeshesOfSeveralPartsInEveryFormat) {
  const TemporaryFolder folder;
  std::array<int, 3> seen{};
  for (std::uint64_t seed = 1000; seed < 1008 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const RandomPly ply(seed, kBlockElements + 1000, 2 * kBlockElements + 77);
    ++seen[static_cast<int>(ply.format())];
    expect_reads_back(folder, ply);
  }
  EXPECT_GT(seen[0] * seen[1] * seen[2], 0) << "the seeds leave a format out";
}

// 140,000 vertices and 300,000 triangles, little-endian.
std::string big_triangle_file(Triangles& triangles) {
  constexpr std::uint32_t kVertices = 140000;
  constexpr std::uint32_t kFaces = 300000;
  PlyBody body(BodyFormat::kLittle);
  for (std::uint32_t i = 0; i < kVertices; ++i) body.put("float", i).put("float", 2.0 * i).put("float", 0);
  for (std::uint32_t i = 0; i < kFaces; ++i) {
    triangles.push_back({i % kVertices, (7 * i) % kVertices, (i + 5) % kVertices});
    body.list("uchar", "int", {triangles[i].begin(), triangles[i].end()});
  }
  return ply_header(
             BodyFormat::kLittle,
             fmt::format("element vertex {}\n{}element face {}\nproperty list uchar int vertex_indices\n",
                         kVertices, kFloatVertex, kFaces)) +
         body.bytes();
}

TEST(Ply, TriangleFilesSplitIntoPartsThatCanBeReadInAnyOrder) {
  const TemporaryFolder folder;
  Triangles triangles;
  const auto source = open_source(folder.write("big.ply", big_triangle_file(triangles)));
  auto parts = source->parts();
  ASSERT_EQ(parts.size(), 5U);
  std::uint64_t next = 0;
  for (std::size_t i = 2; i < 5; ++i) {
    EXPECT_EQ(parts[i].kind, PartKind::kFaces);
    EXPECT_EQ(parts[i].first, next);
    next += parts[i].count;
  }
  EXPECT_EQ(next, triangles.size());
  Triangles read;
  for (std::size_t i = 5; i-- > 2;) {
    Collected part;
    ASSERT_TRUE(source->read(parts[i], part));
    read.insert(read.begin(), part.faces.begin(), part.faces.end());
  }
  EXPECT_EQ(read, triangles);
  Collected second;
  ASSERT_TRUE(source->read(parts[1], second));
  EXPECT_EQ(second.delivered, 140000 - kBlockElements);
  EXPECT_EQ(second.positions.back(), (std::array<double, 3>{139999, 279998, 0}));
}

// A two-cornered and a four-cornered face together are as long as two triangles.
TEST(Ply, FacesThatOnlyAddUpToTrianglesAreReadSequentially) {
  const TemporaryFolder folder;
  constexpr std::uint32_t kFaces = 2 * kBlockElements;
  PlyBody body(BodyFormat::kLittle);
  for (int i = 0; i < 4; ++i) body.put("float", i).put("float", 0).put("float", 0);
  body.list("uchar", "int", {0, 1});
  // From here on every row is four bytes before the place where triangles would put it: the count of three
  // that a reader sees in the second part is an index, and what follows is no index.
  for (std::uint32_t i = 2; i < kFaces; ++i) body.list("uchar", "int", {3, 3, 3});
  body.list("uchar", "int", {0, 1, 2, 3});
  const auto source = open_source(folder.write(
      "mixed.ply",
      ply_header(BodyFormat::kLittle,
                 fmt::format("element vertex 4\n{}element face {}\nproperty list uchar int vertex_indices\n",
                             kFloatVertex, kFaces)) +
          body.bytes()));
  const auto parts = source->parts();
  ASSERT_EQ(parts.size(), 3U);
  for (std::size_t i = 1; i < 3; ++i) {
    Collected part;
    EXPECT_FALSE(source->read(parts[i], part)) << "part " << i;
    EXPECT_TRUE(part.faces.empty());
  }
  const Collected read = collect(*source);
  ASSERT_EQ(read.faces.size(), kFaces);
  EXPECT_EQ(read.faces[0], (std::array<std::uint32_t, 3>{3, 3, 3}));
  EXPECT_EQ(read.faces[kFaces - 2], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(read.faces[kFaces - 1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(read.noted.polygons, 1U);
  EXPECT_EQ(read.noted.small, 1U);
}

// As above, but the shifted rows look like triangles: only the faces before them tell.
TEST(Ply, AnIndexOutOfRangeIsNoErrorWhereEarlierFacesAreNotTriangles) {
  const TemporaryFolder folder;
  constexpr std::uint32_t kFaces = 3 * kBlockElements;
  constexpr int kVertices = 1100;
  PlyBody body(BodyFormat::kLittle);
  for (int i = 0; i < kVertices; ++i) body.put("float", i).put("float", 0).put("float", 0);
  body.list("uchar", "ushort", {0, 1});
  // Rows of seven bytes, 3 FF 03 .. .. .. .., read from the third one on: a count of 3, two indices that are
  // right, and the index 3 FF, which is 65283.
  for (std::uint32_t i = 2; i < kFaces; ++i) body.list("uchar", "ushort", {0x03FF, 1, 2});
  body.list("uchar", "ushort", {0, 1, 2, 3});
  const auto source = open_source(folder.write(
      "mixed.ply",
      ply_header(BodyFormat::kLittle, fmt::format("element vertex {}\n{}element face {}\nproperty "
                                                  "list uchar ushort vertex_indices\n",
                                                  kVertices, kFloatVertex, kFaces)) +
          body.bytes()));
  ASSERT_EQ(source->parts().size(), 4U);
  Collected part;
  EXPECT_FALSE(source->read(source->parts()[2], part));
  EXPECT_EQ(collect(*source).faces.size(), kFaces);
}

// The faces are a byte longer than triangles, and the file ends in what could be white space behind a shorter
// one.
TEST(Ply, VerticesBehindFacesOfAnySizeAreFound) {
  const TemporaryFolder folder;
  PlyBody body(BodyFormat::kLittle);
  body.list("uchar", "uchar", {0, 1, 2, 0}).list("uchar", "uchar", {2, 1, 0});
  for (int i = 0; i < 3; ++i) body.put("uchar", i).put("uchar", 7).put("uchar", ' ');
  const Collected read = collect(folder.write(
      "v.ply", ply_header(BodyFormat::kLittle,
                          "element face 2\nproperty list uchar uchar vertex_indices\nelement vertex "
                          "3\nproperty uchar x\nproperty uchar y\nproperty uchar z\n") +
                   body.bytes()));
  EXPECT_EQ(read.positions, (std::vector<std::array<double, 3>>{{0, 7, 32}, {1, 7, 32}, {2, 7, 32}}));
  EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}, {0, 2, 0}, {2, 1, 0}}));
}

TEST(Ply, TriangleStripsAlternateAndRestart) {
  const TemporaryFolder folder;
  for (const BodyFormat format : {BodyFormat::kAscii, BodyFormat::kLittle, BodyFormat::kBig}) {
    PlyBody body(format);
    for (int i = 0; i < 6; ++i) body.put("float", i).put("float", 0).put("float", 0).end_row();
    body.list("int", "int", {0, 1, 2, 3, 4, -1, 2, 1, 5, -1, 0, 1, -1}).end_row();
    const auto path = folder.write(
        "strips.ply",
        ply_header(format, fmt::format("element vertex 6\n{}element tristrips 1\nproperty list int int "
                                       "vertex_indices\n",
                                       kFloatVertex)) +
            body.bytes());
    const Collected read = collect(path);
    EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {2, 1, 5}}));
    EXPECT_EQ(read.noted.small, 1U) << "the strip of two corners";
  }
}

TEST(Ply, PolygonsMayHaveAsManyCornersAsABlockHasRoomFor) {
  const TemporaryFolder folder;
  for (const BodyFormat format : {BodyFormat::kAscii, BodyFormat::kBig})
    for (const std::uint32_t corners :
         {std::uint32_t{kBlockElements} + 2, std::uint32_t{kBlockElements} + 3, 400000U}) {
      PlyBody body(format);
      for (int i = 0; i < 5; ++i) body.put("float", i).put("float", 0).put("float", 0).end_row();
      body.list("uint", "int", {0, 1, 2}).end_row();  // does not make the next one longer than a block
      std::vector<double> indices(corners);
      for (std::uint32_t i = 0; i < corners; ++i) indices[i] = i % 5;
      body.list("uint", "int", indices).end_row();
      const auto path = folder.write(
          "fan.ply",
          ply_header(format,
                     fmt::format("element vertex 5\n{}element face 2\nproperty list uint int vertex_index\n",
                                 kFloatVertex)) +
              body.bytes());
      if (corners > kBlockElements + 2) {
        expect_bad(path, {"face 1", "more than 131074 corners"});
        continue;
      }
      const Collected read = collect(path);
      ASSERT_EQ(read.faces.size(), corners - 1);
      EXPECT_EQ(read.faces[8], (std::array<std::uint32_t, 3>{0, 8 % 5, 9 % 5}));
      EXPECT_EQ(read.noted.polygons, 1U);
    }
}

std::string one_triangle(std::string_view header_lines, std::string_view rows) {
  return fmt::format("ply\nformat ascii 1.0\n{}end_header\n{}", header_lines, rows);
}

TEST(Ply, FloatColoursAreScaledRoundedAndClamped) {
  const TemporaryFolder folder;
  const Collected read = collect(folder.write(
      "c.ply",
      one_triangle("element vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float "
                   "red\nproperty float green\nproperty float blue\n",
                   "0 0 0 0.5 1.02 -1\n0 0 0 0.001 1 0.25\n")));
  EXPECT_EQ(read.colors[0], (std::array<std::uint8_t, 4>{128, 255, 0, 255}));
  EXPECT_EQ(read.colors[1], (std::array<std::uint8_t, 4>{0, 255, 64, 255}));
}

TEST(Ply, TextKeepsDoublePrecisionWhateverTheHeaderSays) {
  const TemporaryFolder folder;
  const Collected read =
      collect(folder.write("d.ply", one_triangle(fmt::format("element vertex 1\n{}", kFloatVertex),
                                                 "500000.001 +1e-3 -1e-400\n")));
  EXPECT_EQ(read.positions[0], (std::array<double, 3>{500000.001, 0.001, 0}));
}

TEST(Ply, NormalsThatAreNotFiniteAreUnknown) {
  const TemporaryFolder folder;
  const std::string header = fmt::format(
      "element vertex 2\n{}property float nx\nproperty float ny\nproperty float nz\n", kFloatVertex);
  const Collected text = collect(folder.write("n.ply", one_triangle(header, "0 0 0 nan 1 0\n0 0 0 0 1 0\n")));
  EXPECT_EQ(text.normals, (std::vector<std::array<float, 3>>{{0, 0, 0}, {0, 1, 0}}));
  PlyBody body(BodyFormat::kLittle);
  for (const double x : {std::numeric_limits<double>::infinity(), 0.0})
    for (const double value : {0.0, 0.0, 0.0, x, 1.0, 0.0}) body.put("float", value);
  const Collected binary =
      collect(folder.write("n.ply", ply_header(BodyFormat::kLittle, header) + body.bytes()));
  EXPECT_EQ(binary.normals, text.normals);
}

TEST(Ply, RowsMayGoOnOverSeveralLines) {
  const TemporaryFolder folder;
  const Collected read = collect(folder.write(
      "l.ply",
      one_triangle(fmt::format("element vertex 3\n{}element face 1\nproperty list uchar int vertex_indices\n",
                               kFloatVertex),
                   "0 0\n0\n\n1 0 0\n  0 1 0  \n3\n0 1\n2")));
  EXPECT_EQ(read.faces, (Triangles{{0, 1, 2}}));
}

TEST(Ply, HeadersMayEndTheirLinesWithReturnsAlone) {
  const TemporaryFolder folder;
  std::string header = ply_header(BodyFormat::kLittle,
                                  "element vertex 1\nproperty uchar x\nproperty uchar y\nproperty "
                                  "uchar z\n");
  std::replace(header.begin(), header.end(), '\n', '\r');
  const Collected read = collect(folder.write("r.ply", header + "\n\r\t"));
  EXPECT_EQ(read.positions[0], (std::array<double, 3>{10, 13, 9}));
}

TEST(Ply, TexturesAreRefusedUnlessDropped) {
  const TemporaryFolder folder;
  const std::string vertex = fmt::format("element vertex 1\n{}", kFloatVertex);
  const auto st =
      folder.write("st.ply", one_triangle(vertex + "property float s\nproperty float t\n", "0 0 0 1 1\n"));
  expect_bad(st, {"vertex.s", "vertex.t", "--drop-textures"});
  const auto source = open_source(st, {.drop_textures = true});
  EXPECT_EQ(source->info().textures, (std::vector<std::string>{"vertex.s", "vertex.t"}));
  EXPECT_EQ(collect(*source).positions.size(), 1U);
  expect_bad(folder.write("u.ply", one_triangle(vertex + "property float texture_u\n", "0 0 0 1\n")),
             {"texture_u"});
  expect_bad(
      folder.write("w.ply", one_triangle(vertex + "element face 0\nproperty list uchar int vertex_indices\n"
                                                  "property list uchar float texcoord\n",
                                         "0 0 0\n")),
      {"face.texcoord"});
  expect_bad(folder.write("f.ply", one_triangle("comment TextureFile skin.png\n" + vertex, "0 0 0\n")),
             {"skin.png"});
  // A single s is no texture coordinate.
  EXPECT_EQ(open_source(folder.write("s.ply", one_triangle(vertex + "property float s\n", "0 0 0 1\n")))
                ->info()
                .skipped,
            (std::vector<std::string>{"vertex.s"}));
}

TEST(Ply, ReadsTheScansOfTheDataFolder) {
  for (const auto& [name, vertices, triangles] : {std::tuple{"armadillo.ply", 43243U, 86482U},
                                                  {"gargo.ply", 25002U, 50000U},
                                                  {"stanford-bunny.ply", 35947U, 69451U}}) {
    const auto path = std::filesystem::path(COLOSSUS_SHARED_DATA) / name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
    const Collected read = collect(path);
    EXPECT_EQ(read.positions.size(), vertices);
    EXPECT_EQ(read.faces.size(), triangles);
  }
}

}  // namespace
}  // namespace colossus::input
