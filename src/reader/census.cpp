#include "reader/census.hpp"

#include <algorithm>

namespace colossus::reader {
namespace {

using codec::ScaledPosition;

core::Hash128 edge_hash(const ScaledPosition& a, const ScaledPosition& b) {
  const std::array<ScaledPosition, 2> ends = a < b ? std::array{a, b} : std::array{b, a};
  return core::hash128(std::as_bytes(std::span(ends)));
}

FlatTriangle flat_triangle(std::array<ScaledPosition, 3> corners) {
  FlatTriangle flat;
  for (std::size_t k = 0; k < 3; ++k) flat.edges[k] = edge_hash(corners[k], corners[(k + 1) % 3]);
  flat.direction = 1;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (corners[j] < corners[i]) {
      std::swap(corners[i], corners[j]);
      flat.direction = -flat.direction;
    }
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  flat.corners = core::hash128(std::as_bytes(std::span(corners)));
  return flat;
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

PartCensus take_census(std::span<const ScaledPosition> positions, std::span<const std::uint8_t> shared_bits,
                       std::span<const mesh::Triangle> triangles) {
  PartCensus census;
  std::vector<std::uint64_t> keys;
  keys.reserve(triangles.size() * 3);
  for (const mesh::Triangle& t : triangles) {
    if ((shared_bits[t[0]] & shared_bits[t[1]] & shared_bits[t[2]]) != 0) {
      census.flat.push_back(flat_triangle({positions[t[0]], positions[t[1]], positions[t[2]]}));
      continue;
    }
    ++census.inside.triangles;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k];
      const std::uint64_t b = t[(k + 1) % 3];
      keys.push_back(std::min(a, b) << 32 | std::max(a, b));
    }
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 0; i < keys.size();) {
    std::size_t end = i;
    while (end < keys.size() && keys[end] == keys[i]) ++end;
    const auto a = static_cast<std::uint32_t>(keys[i] >> 32);
    const auto b = static_cast<std::uint32_t>(keys[i]);
    const auto uses = static_cast<std::uint32_t>(end - i);
    if ((shared_bits[a] & shared_bits[b]) != 0)
      census.shared.push_back({edge_hash(positions[a], positions[b]), uses});
    else
      count(census.inside, uses);
    i = end;
  }
  return census;
}

void LevelCensus::Part::append(PartCensus&& census) {
  inside.triangles += census.inside.triangles;
  inside.border_edges += census.inside.border_edges;
  inside.nonmanifold_edges += census.inside.nonmanifold_edges;
  shared.insert(shared.end(), census.shared.begin(), census.shared.end());
  flat.insert(flat.end(), census.flat.begin(), census.flat.end());
}

void LevelCensus::add(PartCensus&& census, bool is_leaf) {
  (is_leaf ? leaves_ : split_).append(std::move(census));
}

EdgeCounts LevelCensus::finish_level() {
  EdgeCounts counts;
  counts.triangles = leaves_.inside.triangles + split_.inside.triangles;
  counts.border_edges = leaves_.inside.border_edges + split_.inside.border_edges;
  counts.nonmanifold_edges = leaves_.inside.nonmanifold_edges + split_.inside.nonmanifold_edges;

  merge_uses(leaves_.shared);
  std::vector<EdgeUses> edges = std::move(split_.shared);
  std::vector<FlatTriangle> flat = std::move(split_.flat);
  flat.insert(flat.end(), leaves_.flat.begin(), leaves_.flat.end());
  std::sort(flat.begin(), flat.end(),
            [](const FlatTriangle& a, const FlatTriangle& b) { return a.corners < b.corners; });
  for (std::size_t i = 0; i < flat.size();) {
    const std::size_t first = i;
    std::int64_t net = 0;
    for (; i < flat.size() && flat[i].corners == flat[first].corners; ++i) net += flat[i].direction;
    const auto remaining = static_cast<std::uint32_t>(net < 0 ? -net : net);
    counts.triangles += remaining;
    if (remaining > 0)
      for (const core::Hash128& edge : flat[first].edges) edges.push_back({edge, remaining});
  }
  merge_uses(edges);
  // Both are sorted and without repetitions: walk through them together.
  auto leaf = leaves_.shared.begin();
  for (const EdgeUses& edge : edges) {
    for (; leaf != leaves_.shared.end() && leaf->edge < edge.edge; ++leaf) count(counts, leaf->uses);
    const bool is_in_both = leaf != leaves_.shared.end() && leaf->edge == edge.edge;
    count(counts, edge.uses + (is_in_both ? leaf->uses : 0));
    if (is_in_both) ++leaf;
  }
  for (; leaf != leaves_.shared.end(); ++leaf) count(counts, leaf->uses);
  split_ = {};
  return counts;
}

}  // namespace colossus::reader
