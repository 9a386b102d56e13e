#include "pipeline/ingest/piece.hpp"

#include <algorithm>
#include <limits>

#include "pipeline/facts/fingerprint.hpp"

namespace colossus::pipeline::ingest {
namespace {

using core::ByteReader;
using core::Bytes;
using NarrowTriangle = std::array<std::uint16_t, 3>;

struct PieceHeader {
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
};

bool is_narrow(std::size_t vertex_count) {
  return vertex_count <= std::size_t{std::numeric_limits<std::uint16_t>::max()} + 1;
}

}  // namespace

PackedVertices::PackedVertices(const facts::Catalog& catalog, std::size_t count)
    : has_normals_(catalog.has_normals), has_colors_(catalog.has_colors) {
  positions_.reserve(count);
  if (has_normals_) normals_.reserve(count);
  if (has_colors_) colors_.reserve(count);
}

void PackedVertices::add(const mesh::Vertex& v) {
  positions_.push_back(facts::with_fingerprint(v.position, v.fingerprint));
  if (has_normals_) normals_.push_back(v.normal);
  if (has_colors_) colors_.push_back(v.color);
}

void PackedVertices::read(const facts::Catalog& catalog, ByteReader& reader, std::uint64_t count,
                          std::vector<mesh::Vertex>& vertices) {
  const auto positions = reader.get_array<mesh::Point>(count);
  const auto normals = reader.get_array<mesh::Normal16>(catalog.has_normals ? count : 0);
  const auto colors = reader.get_array<mesh::Color>(catalog.has_colors ? count : 0);
  COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
  for (std::size_t i = 0; i < count; ++i) {
    mesh::Vertex v;
    facts::take_apart(positions[i], v);
    v.normal = catalog.has_normals ? normals[i] : mesh::Normal16{0, 0, 0};
    if (catalog.has_colors) v.color = colors[i];
    vertices.push_back(v);
  }
}

scratch::RecordRef store_piece(const run::Workspace& workspace, const facts::Catalog& catalog,
                               const Piece& piece) {
  const PieceHeader header{static_cast<std::uint32_t>(piece.vertices.size()),
                           static_cast<std::uint32_t>(piece.triangles.size())};
  PackedVertices vertices(catalog, piece.vertices.size());
  for (const mesh::Vertex& v : piece.vertices) vertices.add(v);
  std::vector<NarrowTriangle> narrow;
  std::span<const std::byte> triangles = core::as_bytes(piece.triangles);
  if (is_narrow(piece.vertices.size())) {
    narrow.reserve(piece.triangles.size());
    for (const mesh::Triangle& t : piece.triangles)
      narrow.push_back({static_cast<std::uint16_t>(t[0]), static_cast<std::uint16_t>(t[1]),
                        static_cast<std::uint16_t>(t[2])});
    triangles = core::as_bytes(narrow);
  }
  return workspace.writer.append(static_cast<std::uint32_t>(facts::RecordKind::kPiece),
                                 {std::as_bytes(std::span(&header, 1)), core::as_bytes(piece.numbers),
                                  vertices.positions(), vertices.normals(), vertices.colors(), triangles});
}

void load_piece(const run::Workspace& workspace, const facts::Catalog& catalog,
                const scratch::RecordRef& record, Piece& piece) {
  const Bytes bytes = workspace.reader.read(record);
  ByteReader reader(bytes);
  const auto header = reader.get<PieceHeader>();
  const auto first = static_cast<std::uint32_t>(piece.vertices.size());
  const auto numbers = reader.get_array<std::uint64_t>(header.vertices);
  piece.numbers.insert(piece.numbers.end(), numbers.begin(), numbers.end());
  PackedVertices::read(catalog, reader, header.vertices, piece.vertices);
  const auto add = [&](const auto& triangles) {
    for (const auto& t : triangles) piece.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  };
  if (is_narrow(header.vertices))
    add(reader.get_array<NarrowTriangle>(header.triangles));
  else
    add(reader.get_array<mesh::Triangle>(header.triangles));
  COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
  workspace.reporter.add_triangles(header.triangles);
}

Piece PieceCutter::take(std::span<const std::uint32_t> triangles) {
  Piece piece;
  std::vector<std::uint32_t> used;
  piece.triangles.reserve(triangles.size());
  for (const auto i : triangles) {
    mesh::Triangle t = piece_.triangles[i];
    for (auto& v : t) {
      if (renumbered_[v] == kNone) {
        renumbered_[v] = static_cast<std::uint32_t>(used.size());
        used.push_back(v);
      }
      v = renumbered_[v];
    }
    piece.triangles.push_back(t);
  }
  piece.numbers.reserve(used.size());
  piece.vertices.reserve(used.size());
  for (const auto v : used) {
    piece.numbers.push_back(piece_.numbers[v]);
    piece.vertices.push_back(piece_.vertices[v]);
    renumbered_[v] = kNone;
  }
  return piece;
}

}  // namespace colossus::pipeline::ingest
