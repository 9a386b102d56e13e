// Inputs as streams of blocks: PLY, OBJ, STL and OFF, read in parts by any rank without ever holding a whole
// file.
//
// A Source is opened on every rank that reads of it (opening is deterministic, so all ranks see the same
// parts); the parts of a file are its work units. Their number and size depend on the file alone, never on
// the number of ranks. Reading all parts in order delivers every vertex and every face once, faces in the
// file's order.
//
// Conventions of all formats
// - Vertices and faces count from 0 in blocks and in messages (text formats also name the line, from 1).
// - Positions are doubles: text is rounded to the nearest double even where a header says float.
// - A polygon becomes the fan from its first corner, (0,1,2), (0,2,3), ...; a face with fewer than three
// corners is
//   skipped and counted in OddFaces. Degenerate and duplicate triangles are delivered.
// - Colours are RGBA bytes: floats are scaled by 255, rounded and clamped; 16-bit unsigned colours are scaled
// by 1/257;
//   other integers are clamped; a missing alpha is 255; a colour that is not a number is bad data.
// - A normal that is not finite is delivered as (0, 0, 0), which means "not known": scanners write such
// normals at
//   isolated vertices, and they can be computed. Normals are delivered as stored, not scaled to unit length.
// - Bad data (an index out of range, a coordinate that is not finite, a truncated file, counts that lie, more
// than 64
//   bytes of white space or anything else behind the last element of a binary file or the last row of an
//   ASCII one, more than 2^32 - 1 vertices) throws core::Error(kBadData) with the file, the element and its
//   number, what was expected and what was found. Blocks delivered before are then void.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace colossus::input {

// No block holds more vertices or triangles than this.
inline constexpr std::size_t kBlockElements = std::size_t{1} << 17;

struct VertexBlock {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<float, 3>> normals;        // empty, or one per position
  std::vector<std::array<std::uint8_t, 4>> colors;  // RGBA; empty, or one per position
};

struct TriangleBlock {
  std::vector<std::array<std::uint32_t, 3>> triangles;  // vertex indices from 0 within the file
};

// Faces that were not triangles.
struct OddFaces {
  std::uint64_t polygons = 0;  // more than three corners: delivered as fans
  std::uint64_t small = 0;     // fewer than three corners (also of a strip's pieces): skipped
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
  // Once at the end of a part that had any.
  virtual void odd_faces(const OddFaces& /*odd*/) {}
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
  bool has_colors = false;
  std::vector<std::string>
      skipped;  // what is in the file and not read, by name, e.g. "vertex.quality", "element edge"
  std::vector<std::string> textures;  // texture coordinates and material files that --drop-textures drops
  std::uint64_t vertex_count = 0;     // as declared or counted; 0 where only reading tells (ASCII STL)
  std::uint64_t face_count = 0;       // likewise; faces (strips) of the file, not triangles
  std::uint64_t bytes = 0;
};

struct SourceOptions {
  bool drop_textures = false;  // without it, texture coordinates and material files are an error
};

// One open input. read() is const and may be called from several threads. Not collective.
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
  // triangle; nothing of the part has been delivered then. The caller must drop all triangles of this file
  // and read sequential_face_parts().
  virtual bool read(const Part& part, BlockSink& sink) const = 0;

  // What replaces all kFaces parts after read() returned false; empty for sources without kFaces parts.
  virtual std::vector<Part> sequential_face_parts() const { return {}; }

 protected:
  Source() = default;
  SourceInfo info_;
};

// Opens a PLY, OBJ, STL or OFF file; the content decides, then the extension. Reads the header only, except
// for OBJ (one pass over the file, and 16 bytes of memory per vertex if it has usable normals) and OFF with
// colours (one pass over the vertices). Throws core::Error(kBadData) for a missing or unknown file, a
// malformed header, a size that contradicts it, a file without vertices, or textures without
// options.drop_textures.
std::unique_ptr<Source> open_source(const std::filesystem::path& path, const SourceOptions& options = {});

// The input files of a command line, in order. `@list.txt` stands for the paths in list.txt: one per line,
// relative to the list's folder; blank lines and lines that start with # are ignored; a list names no other
// lists. Throws core::Error(kBadData) for a list that cannot be read or names no file. Does not look at the
// files themselves.
std::vector<std::filesystem::path> expand_inputs(std::span<const std::string> arguments);

}  // namespace colossus::input
