// Checks everything about a container that can be checked without its input, and with it the stored errors.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "reader/distance.hpp"
#include "reader/statue.hpp"

namespace colossus::reader {

enum class FindingKind : std::uint8_t {
  kDamage,       // a node's bytes: checksum, frame, payload, or not what its row says
  kStructure,    // what the rows say about each other
  kBounds,       // a decoded position outside the row's bounds
  kFace,         // two tetrahedra disagree about a face of the hierarchy
  kEdge,         // ... or about an edge of it
  kErrorGrowth,  // a parent's error smaller than a child's
  kBorder,       // border edges in a cut of a closed surface
  kNonManifold,  // non-manifold edges in a cut of a surface without
  kDistance,     // farther from the input than the stored error
  kLooseError,   // more than a tenth of the nodes store an error of more than four times the sampled distance
};
inline constexpr std::size_t kFindingKinds = 10;
std::string_view name_of(FindingKind kind);

struct Finding {
  FindingKind kind = FindingKind::kDamage;
  std::string message;
};

struct VerifyOptions {
  const SurfaceIndex* against = nullptr;  // the input, in world units; null: distances are not checked
  std::size_t samples_per_node = 2000;
  std::uint64_t seed = 1;
  std::size_t examples_per_kind = 5;  // messages kept of each kind; all are counted
};

// The uniform cut of one level.
struct LevelReport {
  std::uint32_t level = 0;
  std::uint64_t nodes = 0;  // rows of this level
  std::uint64_t triangles = 0;
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
};

struct VerifyReport {
  std::vector<Finding> findings;                      // by kind, then in the order of the rows; bounded
  std::array<std::uint64_t, kFindingKinds> counts{};  // all of them
  std::uint64_t nodes = 0;
  std::uint64_t faces = 0;           // of the hierarchy, checked
  std::uint64_t nonempty_faces = 0;  // ... that the surface crosses
  std::uint64_t edges = 0;           // of the hierarchy, along which a surface ends
  std::vector<LevelReport> levels;
  // With the input only:
  std::uint64_t samples = 0;
  std::uint64_t measured_nodes = 0;  // whose stored error is above the lattice's resolution
  std::uint64_t loose_nodes = 0;     // ... and above four times the largest sampled distance
  double greatest_ratio = 0.0;       // of a sampled distance to the stored error

  std::uint64_t count(FindingKind kind) const { return counts[static_cast<std::size_t>(kind)]; }
  std::uint64_t total() const;
  bool is_ok() const { return total() == 0; }
};

// What is expected of the cuts: metadata counts named "border_edges" and "nonmanifold_edges" are the input's;
// where the container has none, the finest cut is what coarser ones are compared with. If the input has none,
// no cut may have any; else they are reported only.
//
// Distances: of samples_per_node deterministic samples of each node to the input; a relative 1e-9 and the
// last place of the coordinates are allowed for the arithmetic. Whether an error is loose is judged by the
// larger of these and the distances of the input's vertices in the node's tetrahedra to the node (an error
// also tells what simplification cut off), of the node and those below (their errors never exceed it). Nodes
// whose error is at most the lattice's own rounding, or four units of weight, do not count as loose.
//
// Never throws for damage in nodes (that is a finding); throws Error(kIo) when the device fails. Decodes each
// node once, on all usable processors; the report does not depend on their number. Memory: some 60 bytes per
// face of each tetrahedron, 32 per edge within faces of one level and of the leaves above it, and a batch of
// nodes.
VerifyReport verify(const Statue& statue, const VerifyOptions& options = {});

// For people: a table per level, what was checked, and the findings.
std::string to_text(const VerifyReport& report);

}  // namespace colossus::reader
