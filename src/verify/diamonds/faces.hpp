// Private to this folder: the invariant of the hierarchy's faces and edges, checked exactly.
//
// Take the directed edges of a tetrahedron's mesh that do not cancel within it (by vertex index), with both
// ends marked on a common face. With exactly one common face the edge belongs to that face's polyline; with
// two it lies along the edge of the tetrahedron in which they meet. Polylines are compared as chains:
// multisets of directed pairs of exact positions, without those of length zero, opposite pairs cancelled
// (quantisation may merge such a pair on one side and keep it on the other; either way it bounds nothing).
//
// Every conforming cut is closed inside if and only if
// * of all tetrahedra, of any level, that have one face: those on one side have equal chains, those on the
// other side
//   the reverse, and a chain that is not empty has both sides;
// * along an edge E of the hierarchy: the chain of a split tetrahedron whose split keeps E is the sum of its
// halves'
//   chains along E, and the chains of the tetrahedra around E that are leaves or are bisected at E sum to
//   nothing.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "reader/diamonds/statue.hpp"

namespace colossus::verify::diamonds {

struct DirectedEdge {
  codec::coded::ScaledPosition from{};
  codec::coded::ScaledPosition to{};
  friend auto operator<=>(const DirectedEdge&, const DirectedEdge&) = default;
};

// Sorted, without opposite pairs and edges of length zero.
using Chain = std::vector<DirectedEdge>;

// Sorts, drops zero lengths, cancels opposites.
Chain normalized(Chain chain);

struct EdgeChain {
  std::array<geometry::Point, 2> ends{};  // of the hierarchy's edge, in order
  Chain chain;
};

struct BoundaryChains {
  std::array<Chain, 4> faces;    // on the face opposite corner i, as the tetrahedron directs them
  std::vector<EdgeChain> edges;  // only those that are not empty
};

BoundaryChains boundary_chains(const codec::coded::CodedPart& part,
                               const hierarchy::Tetrahedron& tetrahedron);

enum class FaceState : std::uint8_t {
  kKnown,
  kRowless,  // of a half, without a row, of the tetrahedron named: nothing crosses it
  kUnknown,  // of a node whose bytes are damaged
};

// One face of one existing tetrahedron. 48 bytes.
struct FaceEntry {
  core::Hash128 face;      // of its corners
  core::Hash128 polyline;  // of the chain in canonical direction; zero when it is empty
  reader::diamonds::TetrahedronRef tetrahedron;
  std::uint8_t corner = 0;  // opposite the face
  std::uint8_t side = 0;    // of the face that the tetrahedron lies on
  FaceState state = FaceState::kKnown;
};

struct EdgeEntry {
  reader::diamonds::TetrahedronRef tetrahedron;
  EdgeChain edge;
  FaceState state = FaceState::kKnown;  // kUnknown: of a damaged node; nothing can be said around this edge
};

// What one node contributes.
struct NodeBoundary {
  std::vector<FaceEntry> faces;
  std::vector<EdgeEntry> edges;
};

// Entries of all existing tetrahedra of a row, with geometry or not, and of the halves of split ones that
// have no row. `chains[place]` is null where there is no geometry, or where it is unknown because the node is
// damaged.
NodeBoundary node_boundary(const reader::diamonds::Statue& statue, reader::access::RowIndex row,
                           const hierarchy::Diamond& diamond,
                           const std::array<const BoundaryChains*, reader::diamonds::kMaxPlaces>& chains,
                           bool is_damaged);

struct BoundaryReport {
  std::uint64_t faces = 0;           // checked
  std::uint64_t nonempty_faces = 0;  // ... that the surface crosses
  std::uint64_t mismatches = 0;
  std::vector<std::string> examples;  // at most as many as were asked for
};

// Checks all entries together; decodes nodes again to describe an example. Sorts both vectors.
BoundaryReport check_faces(const reader::diamonds::Statue& statue, std::vector<FaceEntry>& entries,
                           std::size_t most_examples);
BoundaryReport check_edges(const reader::diamonds::Statue& statue, std::vector<EdgeEntry>& entries,
                           std::size_t most_examples);

}  // namespace colossus::verify::diamonds
