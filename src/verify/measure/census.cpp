#include "verify/measure/census.hpp"

#include <algorithm>

namespace colossus::verify::measure {
namespace {

using codec::coded::ScaledPosition;

core::Hash128 edge_hash(const ScaledPosition& a, const ScaledPosition& b) {
  const std::array<ScaledPosition, 2> ends = a < b ? std::array{a, b} : std::array{b, a};
  return core::hash128(std::as_bytes(std::span(ends)));
}

// One use of an edge, by indices.
struct EdgeUse {
  std::uint64_t key;  // lesser end, greater end
  bool is_forward;    // from the lesser to the greater
};

std::vector<EdgeUse> sorted_uses(std::span<const mesh::Triangle> triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(triangles.size() * 3);
  for (const mesh::Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k];
      const std::uint64_t b = t[(k + 1) % 3];
      uses.push_back({std::min(a, b) << 32 | std::max(a, b), a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) { return a.key < b.key; });
  return uses;
}

// Adds up equal edges; sorts.
void merge_uses(std::vector<EdgeUses>& edges) {
  std::sort(edges.begin(), edges.end(), [](const EdgeUses& a, const EdgeUses& b) { return a.edge < b.edge; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size();) {
    EdgeUses merged = edges[i];
    for (++i; i < edges.size() && edges[i].edge == merged.edge; ++i) merged.uses += edges[i].uses;
    edges[kept++] = merged;
  }
  edges.resize(kept);
}

void count(EdgeCounts& counts, std::uint32_t uses) {
  if (uses == 1) ++counts.border_edges;
  if (uses > 2) ++counts.nonmanifold_edges;
}

}  // namespace

EdgeCounts& EdgeCounts::operator+=(const EdgeCounts& other) {
  triangles += other.triangles;
  border_edges += other.border_edges;
  nonmanifold_edges += other.nonmanifold_edges;
  return *this;
}

PartCensus take_census(std::span<const ScaledPosition> positions, std::span<const std::uint8_t> shared_bits,
                       std::span<const mesh::Triangle> triangles) {
  PartCensus census;
  census.inside.triangles = triangles.size();
  const std::vector<EdgeUse> edges = sorted_uses(triangles);
  for (std::size_t i = 0; i < edges.size();) {
    const std::uint64_t key = edges[i].key;
    const bool is_forward = edges[i].is_forward;
    std::uint32_t uses = 0;
    bool has_both_directions = false;
    for (; i < edges.size() && edges[i].key == key; ++i, ++uses)
      has_both_directions = has_both_directions || edges[i].is_forward != is_forward;
    if (uses == 2 && !has_both_directions) ++census.inconsistent_edges;
    const auto a = static_cast<std::uint32_t>(key >> 32);
    const auto b = static_cast<std::uint32_t>(key);
    if ((shared_bits[a] & shared_bits[b]) != 0)
      census.shared.push_back({edge_hash(positions[a], positions[b]), uses});
    else
      count(census.inside, uses);
  }
  return census;
}

void LevelCensus::add(PartCensus&& census, bool is_leaf) {
  Part& part = is_leaf ? leaves_ : split_;
  part.inside += census.inside;
  part.has_shared_places = part.has_shared_places || census.has_shared_places;
  part.shared.insert(part.shared.end(), census.shared.begin(), census.shared.end());
}

void report_cut(const LevelCounts& counts, LevelReport& report) {
  report.triangles = counts.cut.triangles;
  report.border_edges = counts.cut.border_edges;
  report.nonmanifold_edges = counts.cut.nonmanifold_edges;
  report.is_partial = counts.is_partial;
  report.has_shared_places = counts.has_shared_places;
}

LevelCounts LevelCensus::finish_level() {
  LevelCounts counts{leaves_.inside, leaves_.is_damaged || split_.is_damaged,
                     leaves_.has_shared_places || split_.has_shared_places};
  counts.cut += split_.inside;
  merge_uses(leaves_.shared);
  std::vector<EdgeUses> edges = std::move(split_.shared);
  split_ = {};
  if (counts.is_partial) return counts;
  merge_uses(edges);
  // Both are sorted and without repetitions: walk through them together.
  auto leaf = leaves_.shared.begin();
  for (const EdgeUses& edge : edges) {
    for (; leaf != leaves_.shared.end() && leaf->edge < edge.edge; ++leaf) count(counts.cut, leaf->uses);
    const bool is_in_both = leaf != leaves_.shared.end() && leaf->edge == edge.edge;
    count(counts.cut, edge.uses + (is_in_both ? leaf->uses : 0));
    if (is_in_both) ++leaf;
  }
  for (; leaf != leaves_.shared.end(); ++leaf) count(counts.cut, leaf->uses);
  return counts;
}

}  // namespace colossus::verify::measure
