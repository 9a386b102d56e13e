// What the tests of the readers share: files in a temporary folder, a sink that keeps everything, and a PLY
// writer that can write what is wrong.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "input/source.hpp"

namespace colossus::support {

using namespace input;

// A folder that vanishes with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "colossus-input-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create " + name);
    path_ = name;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    std::ofstream stream(path_ / name, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!stream) throw std::runtime_error("cannot write " + name);
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Everything that a sink was given; vertices in their places, triangles in the order of delivery.
struct Collected : BlockSink {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<Color> colors;       // as their scale has them
  std::vector<Color> face_colors;  // likewise
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::vector<std::array<std::uint64_t, 2>> polygons;  // first of `faces`, and corners
  Remarks noted;
  std::uint64_t delivered = 0;

  void vertices(std::uint64_t first, VertexBlock&& block) override {
    EXPECT_LE(block.positions.size(), kBlockElements);
    EXPECT_GT(block.positions.size(), 0U);
    delivered += block.positions.size();
    put(first, block.positions, positions);
    put(first, block.normals, normals);
    put(first, block.colors, colors);
    put(first, block.byte_colors, byte_colors);
  }
  void triangles(TriangleBlock&& block) override {
    EXPECT_LE(block.triangles.size(), kBlockElements);
    EXPECT_TRUE(block.colors.empty() || block.colors.size() == block.triangles.size());
    for (const Polygon& polygon : block.polygons) {
      EXPECT_GT(polygon.corners, 3U);
      EXPECT_LE(polygon.first + polygon.corners - 2, block.triangles.size());
      polygons.push_back({faces.size() + polygon.first, polygon.corners});
    }
    put(faces.size(), block.colors, face_colors);
    put(faces.size(), block.byte_colors, byte_face_colors);
    faces.insert(faces.end(), block.triangles.begin(), block.triangles.end());
  }
  void remarks(const Remarks& remarks) override { noted.merge(remarks); }

  void choose_readings(const SourceInfo& info) {
    const ColorScale scale = scale_of(info, noted);
    for (std::size_t i = 0; i < byte_colors.size(); ++i) colors[i] = scale.pick(colors[i], byte_colors[i]);
    for (std::size_t i = 0; i < byte_face_colors.size(); ++i)
      face_colors[i] = scale.pick(face_colors[i], byte_face_colors[i]);
  }

 private:
  template <typename T>
  static void put(std::uint64_t first, const std::vector<T>& from, std::vector<T>& to) {
    if (from.empty()) return;
    to.resize(std::max<std::size_t>(to.size(), first + from.size()));
    std::copy(from.begin(), from.end(), to.begin() + static_cast<std::ptrdiff_t>(first));
  }

  std::vector<Color> byte_colors;
  std::vector<Color> byte_face_colors;
};

// Reads a source as a caller must: all parts, and all faces again when one says that they are not triangles.
inline Collected collect(const Source& source) {
  Collected result;
  Remarks faces;
  bool repeat = false;
  for (const Part& part : source.parts()) {
    Remarks before = std::exchange(result.noted, {});
    repeat |= !source.read(part, result);
    (part.kind == PartKind::kFaces ? faces : before).merge(result.noted);
    result.noted = before;
  }
  if (repeat) {
    result.faces.clear();
    result.face_colors.clear();
    for (const Part& part : source.sequential_face_parts()) EXPECT_TRUE(source.read(part, result));
  } else {
    result.noted.merge(faces);
  }
  EXPECT_EQ(result.delivered, result.positions.size()) << "a vertex came twice or never";
  if (source.info().has_normals) {
    EXPECT_EQ(result.normals.size(), result.positions.size());
  }
  if (source.info().has_colors && !source.info().has_face_colors) {
    EXPECT_EQ(result.colors.size(), result.positions.size());
  }
  result.choose_readings(source.info());
  return result;
}

inline Collected collect(const std::filesystem::path& path, const SourceOptions& options = {}) {
  return collect(*open_source(path, options));
}

// The message of the Error(kBadData) that opening and reading end in; a test failure if they do not.
inline std::string bad_data_message(const std::filesystem::path& path, const SourceOptions& options = {}) {
  try {
    collect(path, options);
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kBadData) << error.what();
    return error.what();
  }
  ADD_FAILURE() << path << " was read without an error";
  return {};
}

// The file is bad data, and the message names it and all of `parts`.
inline void expect_bad(const std::filesystem::path& path, std::initializer_list<std::string_view> parts,
                       const SourceOptions& options = {}) {
  const std::string message = bad_data_message(path, options);
  EXPECT_NE(message.find(path.string()), std::string::npos) << message;
  for (const std::string_view part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << message << " / " << part;
}

enum class BodyFormat { kAscii, kLittle, kBig };

inline const char* format_name(BodyFormat format) {
  constexpr const char* kNames[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  return kNames[static_cast<int>(format)];
}

// The body of a PLY file, value by value. Values are cast to the type that is named.
class PlyBody {
 public:
  explicit PlyBody(BodyFormat format) : format_(format) {}

  PlyBody& put(std::string_view type, double value) {
    if (format_ == BodyFormat::kAscii) {
      text_ += at_line_start_ ? "" : " ";
      text_ += type == "float" || type == "float32" ? fmt::format("{:.17g}", static_cast<float>(value))
                                                    : fmt::format("{:.17g}", value);
      at_line_start_ = false;
    } else if (type == "char" || type == "int8") {
      append(static_cast<std::int8_t>(value));
    } else if (type == "uchar" || type == "uint8") {
      append(static_cast<std::uint8_t>(value));
    } else if (type == "short" || type == "int16") {
      append(static_cast<std::int16_t>(value));
    } else if (type == "ushort" || type == "uint16") {
      append(static_cast<std::uint16_t>(value));
    } else if (type == "int" || type == "int32") {
      append(static_cast<std::int32_t>(value));
    } else if (type == "uint" || type == "uint32") {
      append(static_cast<std::uint32_t>(value));
    } else if (type == "float" || type == "float32") {
      append(static_cast<float>(value));
    } else if (type == "double" || type == "float64") {
      append(value);
    } else {
      throw std::logic_error("no type " + std::string(type));
    }
    return *this;
  }
  PlyBody& list(std::string_view count_type, std::string_view type, const std::vector<double>& values) {
    put(count_type, static_cast<double>(values.size()));
    for (const double value : values) put(type, value);
    return *this;
  }
  PlyBody& end_row(std::string_view line_end = "\n") {
    if (format_ == BodyFormat::kAscii) text_ += line_end;
    at_line_start_ = true;
    return *this;
  }
  const std::string& bytes() const { return text_; }

 private:
  template <typename T>
  void append(T value) {
    std::array<char, sizeof(T)> bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (format_ == BodyFormat::kBig) std::reverse(bytes.begin(), bytes.end());
    text_.append(bytes.data(), bytes.size());
  }

  BodyFormat format_;
  std::string text_;
  bool at_line_start_ = true;
};

// A header from its element and property lines.
inline std::string ply_header(BodyFormat format, std::string_view lines) {
  return fmt::format("ply\nformat {} 1.0\n{}end_header\n", format_name(format), lines);
}

inline constexpr std::string_view kFloatVertex = "property float x\nproperty float y\nproperty float z\n";

}  // namespace colossus::support
