// The triangles of one bucket as one mesh, with the attributes of the positions in its cube.
#pragma once

#include <optional>
#include <span>
#include <utility>

#include "mesh/mesh.hpp"
#include "pipeline/buckets/buckets.hpp"
#include "pipeline/buckets/lost_triangles.hpp"

namespace colossus::pipeline::buckets {

struct EdgeCensus {
  std::uint64_t border = 0;        // one triangle
  std::uint64_t nonmanifold = 0;   // more than two
  std::uint64_t inconsistent = 0;  // two, both in the same direction

  EdgeCensus& operator+=(const EdgeCensus& other) {
    border += other.border;
    nonmanifold += other.nonmanifold;
    inconsistent += other.inconsistent;
    return *this;
  }
  friend EdgeCensus operator+(EdgeCensus a, const EdgeCensus& b) { return a += b; }
  friend EdgeCensus operator-(EdgeCensus a, const EdgeCensus& b) {
    a.border -= b.border;
    a.nonmanifold -= b.nonmanifold;
    a.inconsistent -= b.inconsistent;
    return a;
  }
};

struct BucketCounts {
  std::uint64_t merged_vertices = 0;
  std::uint64_t attribute_seams = 0;
  std::uint64_t color_seams = 0;
  std::uint64_t duplicates = 0;
  std::uint64_t opposites = 0;
  std::uint64_t triangles = 0;  // left of the input's
  std::uint64_t collinear = 0;  // of these
  // By diagonal of the input's box: 1 if one of these has a corner that the lattice can tell from that line.
  std::array<std::uint64_t, 4> is_off_diagonal{};
  EdgeCensus input;   // of these
  EdgeCensus finest;  // of what rounding has left of these
  double area = 0.0;  // of these, before rounding; square units of the lattice of 2^30
};

// The input's bounds on the lattice.
struct InputBox {
  geometry::Point low;
  geometry::Point high;
};

// Welded by position, in the order of the input's faces, without duplicates. A bucket owns the positions in
// its cube: it sees all triangles around them, and only it gives them attributes. The others have those of
// some vertex until load_bucket(). Counts are of positions that the bucket owns, of triangles whose least
// corner, and of edges whose lesser end it owns.
//
// Of triangles over the same three points of the input the first one stays, whichever way the others look:
// exporters write each triangle of a two-sided material twice. (Flat ones, which the lattice cannot tell from
// collinear ones, both stay where they look at each other: they close T-junctions.) What only the lattice or
// rounding lets coincide (fingerprint.hpp) is no copy: it stays, or the surface would open. But of two that
// rounding has laid onto each other with opposite orientation, which lay at different places before, both go
// where they are thin and their longest edge has other triangles: a fin that was folded flat. What the
// removal moves is in lost().
//
// The normal of a position is the sum of the normals that its vertices were read with, or else of the cross
// products of all triangles around it, duplicates too: 128-bit integers, which depend on no order. Colours
// are averaged. Where positions are rounded, this is done before, then normals and colours of all vertices
// that share a rounded position are averaged, each vertex counted once.
class BucketMesh {
 public:
  // Memory: bucket_mesh_bytes().
  BucketMesh(const Rounding& rounding, const CubeId& cube, const InputBox& box, ingest::Piece&& piece);

  mesh::Mesh& mesh() { return mesh_; }
  const BucketCounts& counts() const { return counts_; }
  // Triangles that lattice or rounding took away, as they lie after rounding. All buckets that a triangle's
  // box meets have it.
  const std::vector<LostTriangle>& lost() const { return lost_; }

 private:
  void place(ingest::Piece&& piece);
  void mark_corners(std::span<const std::uint64_t> first_vertices);
  void give_attributes();
  void sum_cross_products(std::vector<bool>& is_unknown);
  void average_rounded();
  void drop_copies();
  bool are_copies(std::uint32_t i, std::uint32_t j) const;
  void measure_triangles();
  bool is_on_diagonal(std::size_t diagonal, const std::array<geometry::Point, 3>& corners) const;
  void round_positions();
  void settle_rounded(const std::vector<std::uint32_t>& first, const std::vector<bool>& is_shared);
  bool drop_fins(const std::vector<std::uint32_t>& touched, std::vector<bool>& is_dropped);
  void lose(const std::array<mesh::Vertex, 3>& corners, double displacement);
  bool owns(const mesh::Triangle& t, const std::vector<mesh::Vertex>& vertices) const;
  bool owns_place(std::uint32_t place) const {
    return cube_.contains(rounding_(places_.vertices[place].position), geometry::kRootBits);
  }

  // Two opposite triangles of mesh_ that rounding has laid onto each other.
  struct Fin {
    std::array<std::uint32_t, 2> triangles;
    std::pair<std::uint32_t, std::uint32_t> longest;  // edge
    double height;
  };
  std::optional<Fin> fin_of(std::uint32_t one, std::uint32_t other) const;

  // A vertex at a place that another one, of another number, has taken.
  struct Other {
    std::uint32_t place;
    mesh::Normal16 normal;
    mesh::Color color;
    std::uint64_t number;
    bool is_corner =
        false;  // of a face with a colour, and another one has brought its vertex: only the colour counts
  };

  Rounding rounding_;
  CubeId cube_;
  InputBox box_;
  mesh::Mesh places_;  // welded before rounding
  std::vector<Other> others_;
  std::vector<std::uint32_t> vertex_counts_;  // per place
  // Per triangle of places_, the fingerprints of its corners; empty where no place has two.
  std::vector<std::array<std::uint16_t, 3>> prints_;
  mesh::Mesh mesh_;
  std::vector<LostTriangle> lost_;
  BucketCounts counts_;
};

// Of the edges of these triangles whose lesser end lies in the cube once it is rounded.
// With `only_at`, of those edges only that have one of these vertices for an end.
EdgeCensus census_of_edges(std::span<const mesh::Triangle> triangles,
                           const std::vector<mesh::Vertex>& vertices, const Rounding& rounding,
                           const CubeId& cube, const std::vector<bool>* only_at = nullptr);

// An upper estimate of the greatest memory of a BucketMesh and of what a scheme then does with it.
std::uint64_t bucket_mesh_bytes(std::uint64_t triangles, std::uint64_t vertices_of_pieces);

}  // namespace colossus::pipeline::buckets
