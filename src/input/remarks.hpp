// What is worth a word about an input that was read all the same.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace colossus::input {

struct SourceInfo;

// How many there were, and the first one.
struct Tally {
  std::uint64_t count = 0;
  std::uint64_t first = ~std::uint64_t{0};

  void add(std::uint64_t number) {
    ++count;
    first = std::min(first, number);
  }
  void merge(const Tally& other) {
    count += other.count;
    first = std::min(first, other.first);
  }
  friend bool operator==(const Tally&, const Tally&) = default;
};

// Of a part, or of all parts of a file: sums, minima and maxima, so that parts can be merged in any order.
// Trivially copyable. Vertices and faces are numbered within the file.
struct Remarks {
  // Faces that were not triangles.
  std::uint64_t polygons = 0;  // more than three corners
  std::uint64_t small = 0;     // fewer than three corners (also of a strip's pieces): skipped
  // Vertices.
  Tally undefined_positions;  // not finite
  Tally undefined_normals;
  // Colours, of vertices or of faces.
  Tally undefined_colors;  // red, green or blue is not a number
  Tally undefined_alphas;
  Tally missing_colors;          // none, where others have one
  std::uint64_t has_colors = 0;  // 1 if a block has some
  // Of components whose scale depends on all values.
  double greatest_color = -std::numeric_limits<double>::infinity();
  double greatest_alpha = -std::numeric_limits<double>::infinity();
  // What only SourceOptions::is_lenient lets pass.
  Tally float_indices;        // faces
  Tally surplus_in_vertices;  // rows with more numbers than they should have
  Tally surplus_in_faces;
  Tally surplus_elsewhere;           // rows of elements that nobody reads
  std::uint64_t trailing_bytes = 0;  // behind the data
  // What is harmless, or not read, but only reading tells.
  std::uint64_t trailing_padding = 0;  // bytes: zeros or white space behind the data
  std::uint64_t attribute_bytes = 0;   // STL triangles whose attribute is not 0, and no colour
  std::uint64_t solid_names = 0;       // STL
  std::uint64_t unread_colors = 0;     // faces with a colour, where vertices have colours
  std::uint64_t color_indices = 0;  // faces whose colour is a number in a table that the file does not have

  bool has_open_colors() const { return greatest_color > -std::numeric_limits<double>::infinity(); }
  bool has_open_alpha() const { return greatest_alpha > -std::numeric_limits<double>::infinity(); }
  void merge(const Remarks& other);
  friend bool operator==(const Remarks&, const Remarks&) = default;
};

// Throws core::Error(kBadData): a triangle uses vertex `vertex` of a file, which is not finite.
[[noreturn]] void fail_position(const std::filesystem::path& path, std::uint64_t vertex,
                                const std::array<double, 3>& position);

// Of all parts of a file: what needs a warning, a sentence each, with the file's name.
std::vector<std::string> warnings_of(const SourceInfo& info, const Remarks& remarks);
// What the file has and nobody reads, by name, as in SourceInfo::skipped, which it follows.
std::vector<std::string> skipped_by(const Remarks& remarks);

}  // namespace colossus::input
