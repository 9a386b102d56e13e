// Triangles with the vertices that they use: what a build moves from the input blocks to the buckets.
#pragma once

#include <span>
#include <vector>

#include "pipeline/facts/catalog.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::ingest {

// Vertices as they lie in scratch: without the attributes that no file of the input has. 12 to 22 bytes each,
// the fingerprint within the 12 of the position (pipeline/facts/fingerprint.hpp). As everywhere before the
// attributes phase, the normal is {0, 0, 0} where none was read.
class PackedVertices {
 public:
  PackedVertices(const facts::Catalog& catalog, std::size_t count);
  void add(const mesh::Vertex& v);
  // To be appended to scratch, one after the other.
  std::span<const std::byte> positions() const { return core::as_bytes(positions_); }
  std::span<const std::byte> normals() const { return core::as_bytes(normals_); }
  std::span<const std::byte> colors() const { return core::as_bytes(colors_); }
  // Appends `count` vertices to `vertices`.
  static void read(const facts::Catalog& catalog, core::ByteReader& reader, std::uint64_t count,
                   std::vector<mesh::Vertex>& vertices);

 private:
  bool has_normals_;
  bool has_colors_;
  std::vector<mesh::Point> positions_;  // with_fingerprint()
  std::vector<mesh::Normal16> normals_;
  std::vector<mesh::Color> colors_;
};

// Numbers of vertices that stand for corners of triangles whose face has a colour: they tell of which vertex,
// and, but for one in 2^27, of which corner. Those of real vertices are smaller.
inline constexpr std::uint64_t kFaceCornerNumbers = std::uint64_t{1} << 63;
inline constexpr int kFaceCornerBits = 27;
constexpr std::uint64_t face_corner_number(std::uint64_t vertex, std::uint64_t corner) {
  return kFaceCornerNumbers | vertex << kFaceCornerBits |
         (corner & ((std::uint64_t{1} << kFaceCornerBits) - 1));
}
// The vertex's own number.
constexpr std::uint64_t vertex_number(std::uint64_t number) {
  return number < kFaceCornerNumbers ? number : (number ^ kFaceCornerNumbers) >> kFaceCornerBits;
}

// Any two vertices have different numbers; positions may be equal. Those without a triangle may be there in a
// group whose faces have colours only.
struct Piece {
  std::vector<std::uint64_t> numbers;  // of the vertices, over all files
  std::vector<mesh::Vertex> vertices;
  std::vector<mesh::Triangle> triangles;  // in the order of the input's faces
};

// Some 25 bytes per triangle where triangles share their vertices.
scratch::RecordRef store_piece(const run::Workspace& workspace, const facts::Catalog& catalog,
                               const Piece& piece);
// Appends to what `piece` has: vertices that it has already come again.
void load_piece(const run::Workspace& workspace, const facts::Catalog& catalog,
                const scratch::RecordRef& record, Piece& piece);

// Takes the triangles of a piece that are wanted, with their vertices in order of first use. Not for use by
// several threads.
class PieceCutter {
 public:
  explicit PieceCutter(const Piece& piece) : piece_(piece), renumbered_(piece.vertices.size(), kNone) {}
  // Linear in the triangles that are taken, not in those of the piece.
  Piece take(std::span<const std::uint32_t> triangles);

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  const Piece& piece_;
  std::vector<std::uint32_t> renumbered_;
};

}  // namespace colossus::pipeline::ingest
