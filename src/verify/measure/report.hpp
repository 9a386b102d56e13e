// What verify() of any scheme finds.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reader/access/statue.hpp"
#include "verify/measure/distance.hpp"

namespace colossus::verify::measure {

enum class FindingKind : std::uint8_t {
  kDamage,         // a node's bytes: checksum, frame, payload, or not what its row says
  kStructure,      // what the rows say about each other
  kBounds,         // a decoded position outside the row's bounds, or the whole's bounds are not the input's
  kFace,           // two tetrahedra disagree about a face of the hierarchy
  kEdge,           // ... or about an edge of it
  kErrorGrowth,    // a parent's error smaller than a child's
  kBorder,         // border edges in a cut of a closed surface
  kNonManifold,    // non-manifold edges in a cut of a surface without
  kDistance,       // farther from the input than the stored error
  kParent,         // a vertex without a parent vertex in the parent cube
  kCondition,      // an edge, or the way to a parent vertex, longer than sigma0 allows
  kMap,            // the parent map does not make a cube's triangles of its children's
  kShared,         // cubes that share a vertex disagree about its parent or its attributes
  kOrientation,    // not as many inconsistently oriented edges within the nodes of a level as are stored
  kCount,          // numbers of triangles or vertices that are not the stored ones
  kArea,           // an area that is not the stored one
  kInputDistance,  // a point of the input farther from a level than the error stored there
  kLooseError,     // more than half of the nodes store an error of more than four times the sampled distance
};
inline constexpr std::size_t kFindingKinds = 18;
std::string_view name_of(FindingKind kind);

struct Finding {
  FindingKind kind = FindingKind::kDamage;
  std::string message;
};

struct VerifyOptions {
  const Surface* against = nullptr;  // the input, in world units; null: nothing is compared with it
  std::size_t samples_per_node = 2000;
  std::uint64_t seed = 1;
  std::size_t examples_per_kind = 5;  // messages kept of each kind; all are counted
};

// Triangles per area near the borders of blocks, over the same of the rest of their cubes. None where a zone
// is empty.
struct CleftDensities {
  std::optional<double> locked;   // near borders that were locked while this level was made
  std::optional<double> earlier;  // near those that were locked while a finer level was made
};

// The uniform cut of one level.
struct LevelReport {
  std::uint32_t level = 0;
  std::uint64_t nodes = 0;  // rows of this level
  std::uint64_t triangles = 0;
  std::uint64_t border_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
  bool has_shared_places = false;        // quantisation has laid vertices of a part onto each other
  bool is_partial = false;               // damaged nodes: edges that these might use are not counted
  std::uint64_t inconsistent_edges = 0;  // within this level's own nodes
  std::uint64_t damaged_nodes = 0;       // of this level's own
  double input_ratio = 0.0;              // greatest of an exact distance from the input to the error there
  std::optional<CleftDensities> clefts;  // where blocks have borders
};

struct VerifyReport {
  std::vector<Finding> findings;                      // by kind, then in the order of the rows; bounded
  std::array<std::uint64_t, kFindingKinds> counts{};  // all of them
  std::uint64_t nodes = 0;
  std::uint64_t faces = 0;           // of the hierarchy, checked
  std::uint64_t nonempty_faces = 0;  // ... that the surface crosses
  std::uint64_t edges = 0;           // of the hierarchy, along which a surface ends
  std::vector<LevelReport> levels;
  std::uint64_t parents = 0;           // parent indices of vertices, checked
  std::uint64_t mapped_triangles = 0;  // ... and triangles, taken to the next coarser level by them
  // With the input only:
  std::uint64_t samples = 0;
  std::uint64_t measured_nodes = 0;  // whose stored error is above the lattice's resolution
  std::uint64_t loose_nodes = 0;     // ... and above four times the largest sampled distance
  double greatest_ratio = 0.0;       // of a sampled distance to the stored error
  std::uint64_t input_samples = 0;   // of the input, measured to the levels
  std::vector<std::string> notes;    // of the finest level; what was not checked, and why

  std::uint64_t count(FindingKind kind) const { return counts[static_cast<std::size_t>(kind)]; }
  std::uint64_t total() const;
  bool is_ok() const { return total() == 0; }
};

// For people: a table per level, what was checked, and the findings.
std::string to_text(const VerifyReport& report);

// For those who verify: collects findings into a report.
class FindingLog {
 public:
  FindingLog(VerifyReport& report, std::size_t examples_per_kind)
      : report_(report), examples_per_kind_(examples_per_kind) {}
  void add(Finding finding) { add_many(finding.kind, 1, {std::move(finding.message)}); }
  // Counts all, keeps the first messages of each kind.
  void add_many(FindingKind kind, std::uint64_t count, std::vector<std::string> messages);
  // Appends a level to the report; levels without a gap from 0 on are expected.
  void start_level(std::uint32_t level);
  // Of samples of the input, measured to the level that was started last.
  void add_input_measure(std::uint64_t samples, double greatest_ratio);
  void add_note(std::string note) { report_.notes.push_back(std::move(note)); }
  // Border and non-manifold edges where the input, or else the finest cut, has none; the latter only where
  // the finest level has none either, as the container says.
  void check_census(const reader::access::Statue& statue);
  // Inconsistently oriented edges where the container says how many each level has.
  void check_orientation(const reader::access::Statue& statue);
  // when more than half of the measured nodes are loose.
  void check_looseness();
  // Findings by kind.
  void sort();

 private:
  void check_edges(FindingKind kind, const char* word, std::uint64_t LevelReport::*member,
                   std::optional<std::uint64_t> of_input);
  VerifyReport& report_;
  std::size_t examples_per_kind_;
};

// A container has its node table before all chunks, and these in the order of the rows, so that a coarse cut
// is one range of the file. What is wrong with offsets that hold; table_offset 0 says nothing of the table.
std::vector<std::string> layout_faults(const std::vector<container::NodeRow>& rows,
                                       std::uint64_t table_offset);
// Of a container whose offsets hold.
void check_layout(const reader::access::Statue& statue, FindingLog& log);

// What double arithmetic may lose in a distance to the root cube of a lattice.
double arithmetic_tolerance(const container::LatticeInfo& lattice);

// A stored error above this many times the sampled distance is loose.
inline constexpr double kLooseFactor = 4.0;

// The same of this one; whether a distance is no more than an error, as far as doubles tell.
bool is_within(const reader::access::Statue& statue, double distance, double error);

// The finding when p, the farthest sample of a row, is farther from the input than the row's error.
std::optional<Finding> check_distance(const reader::access::Statue& statue, reader::access::RowIndex row,
                                      const WorldPoint& p, double distance);

}  // namespace colossus::verify::measure
