// Inputs as streams of input blocks, in this folder blocks for short: PLY, OBJ, STL and OFF, read in parts by
// any rank without ever holding a whole file.
//
// A Source is opened on every rank that reads of it (opening is deterministic, so all ranks see the same
// parts); the parts of a file are its work units. Their number and size depend on the file alone, never on
// the number of ranks. Reading all parts in order delivers every vertex and every face once, faces in the
// file's order.
//
// Conventions of all formats
// - Vertices and faces count from 0 in blocks and in messages (text formats also name the line, from 1).
// - Positions are doubles: text is rounded to the nearest double even where a header says float. A position
//   that is not finite is delivered as it is, and remarked: only who knows which vertices triangles use can
//   tell whether it is bad data. In formats without indices (STL) all are used, and it is.
// - A polygon becomes the fan from its first corner, (0,1,2), (0,2,3), ...; a block says which triangles are
//   such fans, since only positions tell how a polygon is to be cut (geometry/polygon.hpp). A face with fewer
//   than three corners is skipped and remarked. Degenerate and duplicate triangles are delivered.
// - Colours are RGBA bytes, of vertices or, in files whose vertices have none, of faces. 16-bit unsigned ones
//   are scaled by 1/257; other integers are clamped; a missing alpha is 255. Where colours are floats, or
//   text without a type, their scale is found from all values of a file: blocks hold both readings, and
//   scale_of() (colors.hpp) chooses once all parts are read. A colour that is not a number counts as missing.
// - A normal that is not finite is delivered as (0, 0, 0), which means "not known": scanners write such
//   normals at isolated vertices, and they can be computed. Normals are delivered as stored, not scaled to
//   unit length.
// - Zeros or white space behind the data are remarked. Bad data (an index out of range, a truncated file,
//   counts that lie, anything else behind the data, more than 2^32 - 1 vertices) throws core::Error(kBadData)
//   with the file, the element and its number, what was expected and what was found. Blocks delivered before
//   are then void.
// - SourceOptions::is_lenient lets a few things pass that would be bad data, and remarks them: floats for
//   indices and counts of corners, surplus numbers in a row, prose in a header, other bytes behind the data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "core/file.hpp"
#include "input/colors.hpp"
#include "input/remarks.hpp"

namespace colossus::input {

// No input block holds more vertices or triangles than this.
inline constexpr std::size_t kBlockElements = std::size_t{1} << 17;

// An input block of vertices.
struct VertexBlock {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<float, 3>> normals;  // empty, or one per position
  std::vector<Color> colors;                  // empty, or one per position
  std::vector<Color> byte_colors;             // the other reading, see ReadColor; empty, or one per colour
};

// Consecutive triangles of a block that are the fan of one face with more than three corners.
struct Polygon {
  std::uint32_t first = 0;    // triangle of the block
  std::uint32_t corners = 0;  // two more than triangles
  friend bool operator==(const Polygon&, const Polygon&) = default;
};

// An input block of triangles.
struct TriangleBlock {
  std::vector<std::array<std::uint32_t, 3>> triangles;  // vertex indices from 0 within the file
  std::vector<Polygon> polygons;                        // ascending; never cut by the end of a block
  std::vector<Color> colors;                            // of the faces; empty, or one per triangle
  std::vector<Color> byte_colors;                       // as of vertices
};

// Receives what a part holds. In a part with both, vertices and triangles may alternate, and triangles may
// come before the vertices that they name.
class BlockSink {
 public:
  virtual ~BlockSink();
  // Vertices `first`, `first` + 1, ... of the file.
  virtual void vertices(std::uint64_t first, VertexBlock&& block) = 0;
  // The next triangles of the part.
  virtual void triangles(TriangleBlock&& block) = 0;
  // Once, at the end of a part.
  virtual void remarks(const Remarks& /*remarks*/) {}
};

enum class PartKind : std::uint32_t {
  kVertices,  // `count` vertices from `first`: fixed stride, any order
  kFaces,     // `count` triangles from `first`: fixed stride, any order
  kAllFaces,  // all faces, one after the other
  kWhole,     // all vertices and faces, one after the other
  kSoup,      // `count` triangles from `first`, with three vertices of their own each
};

// A work unit; trivially copyable, so that it can be sent to another rank that opened the same file.
struct Part {
  PartKind kind = PartKind::kWhole;
  std::uint64_t first = 0;
  std::uint64_t count = 0;
  friend bool operator==(const Part&, const Part&) = default;
};

struct SourceInfo {
  std::filesystem::path path;
  std::string format;  // for people, e.g. "PLY binary_little_endian"
  bool has_normals = false;
  // Whether blocks have colours. Of a binary STL only reading tells: then a block has some, or has not.
  bool has_colors = false;
  bool has_face_colors = false;    // of faces, where the vertices have none
  bool has_both_readings = false;  // of colours: their scale depends on all values
  // What is in the file and not read, by name, e.g. "vertex.quality", "element edge".
  std::vector<std::string> skipped;
  std::vector<std::string> textures;  // texture coordinates and material files that --drop-textures drops
  std::vector<std::string> passed;    // what opening has let pass that needs a warning, as half a sentence
  std::uint64_t vertex_count = 0;     // as declared or counted; 0 where only reading tells (ASCII STL)
  std::uint64_t face_count = 0;       // likewise; faces (strips) of the file, not triangles
  std::uint64_t bytes = 0;
};

struct SourceOptions {
  bool drop_textures = false;  // without it, texture coordinates and material files are an error
  bool is_lenient = false;     // see above
};

// One input. read() is const and may be called from several threads. Not collective.
class Source {
 public:
  virtual ~Source();
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  const SourceInfo& info() const { return info_; }

  // All parts, in the order of the file's vertices and of its faces.
  virtual std::vector<Part> parts() const = 0;

  // Delivers a part: in blocks of at most kBlockElements, all vertex blocks of the part in ascending order.
  // Memory: a few megabytes. Returns false only for a kFaces part in which, or before which, a face is not a
  // triangle; nothing of the part has been delivered then. The caller must drop all triangles of this file,
  // and what its kFaces parts have remarked, and read sequential_face_parts().
  virtual bool read(const Part& part, BlockSink& sink) const = 0;

  // What replaces all kFaces parts after read() returned false; empty for sources without kFaces parts.
  virtual std::vector<Part> sequential_face_parts() const { return {}; }

  // Closes the file until the next read(), so that there can be more inputs than a process may have open. Not
  // while another thread reads.
  void close();

 protected:
  // `file` is open.
  Source(core::File file, const SourceOptions& options);
  // The file, opened again if it was closed. Throws Error(kBadData) when it has another size by now.
  const core::File& file() const;

  SourceInfo info_;
  SourceOptions options_;

 private:
  mutable std::mutex mutex_;
  mutable core::File file_;
};

// Opens a PLY, OBJ, STL or OFF file; the content decides, then the extension. Reads the header only, except
// for OBJ (one pass over the file, and 16 bytes of memory per vertex if it has usable normals) and OFF whose
// first vertex has more numbers than the header says (one pass over the vertices). Throws
// core::Error(kBadData) for a missing or unknown file, a malformed header, a size that contradicts it, a file
// without vertices, or textures without options.drop_textures.
std::unique_ptr<Source> open_source(const std::filesystem::path& path, const SourceOptions& options = {});

// The input files of a command line, in order. `@list.txt` stands for the paths in list.txt: one per line,
// relative to the list's folder; blank lines and lines that start with # are ignored; a list names no other
// lists. Throws core::Error(kBadData) for a list that cannot be read or names no file. Does not look at the
// files themselves.
std::vector<std::filesystem::path> expand_inputs(std::span<const std::string> arguments);

// The lists among the arguments, by their own paths.
std::vector<std::filesystem::path> lists_of(std::span<const std::string> arguments);

}  // namespace colossus::input
