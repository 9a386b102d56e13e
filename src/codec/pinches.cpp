#include "codec/pinches.hpp"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "core/hash.hpp"
#include "mesh/topology.hpp"

namespace colossus::codec {
namespace {

using mesh::Triangle;

struct WeightsHash {
  std::size_t operator()(const Weights& w) const {
    return core::mix64((std::uint64_t{w[0]} << 32 | w[1]) ^ core::mix64(w[2] + 0x9e3779b97f4a7c15ULL));
  }
};

using Places = std::unordered_map<Weights, std::uint32_t, WeightsHash>;

// Moves a vertex by one step to a place that none of `places` is; weights that are 0 stay 0, and no others become 0.
// False when there is no such place.
bool step_aside(std::uint32_t v, std::vector<Weights>& weights, Places& places) {
  for (std::size_t to = 0; to < 4; ++to)
    for (std::size_t from = 0; from < 4; ++from) {
      Weights moved = weights[v];
      if (to == from || moved[from] < 2 || moved[to] == 0) continue;
      ++moved[to];
      --moved[from];
      if (!places.try_emplace(moved, v).second) continue;
      weights[v] = moved;
      return true;
    }
  return false;
}

std::size_t face_count(const Weights& weights) {
  return static_cast<std::size_t>(std::count(weights.begin(), weights.end(), 0U));
}

}  // namespace

void separate_edges(const std::vector<Triangle>& triangles, std::vector<Weights>& weights) {
  std::vector<std::uint32_t> welded(weights.size());
  std::vector<bool> is_used(weights.size(), false);
  for (const Triangle& t : triangles)
    for (const auto v : t) is_used[v] = true;
  for (int round = 0; round < 4; ++round) {
    Places places;
    places.reserve(weights.size());
    std::vector<bool> is_shared(weights.size(), false);
    bool has_pinch = false;
    for (std::uint32_t v = 0; v < weights.size(); ++v) {
      if (!is_used[v]) continue;
      const auto [entry, is_new] = places.try_emplace(weights[v], v);
      welded[v] = entry->second;
      if (!is_new) is_shared[v] = is_shared[entry->second] = has_pinch = true;
    }
    if (!has_pinch) return;
    // Only edges with an end at a shared place can have fallen together.
    std::vector<Triangle> around_welded;
    for (const Triangle& t : triangles) {
      if (!is_shared[t[0]] && !is_shared[t[1]] && !is_shared[t[2]]) continue;
      around_welded.push_back({welded[t[0]], welded[t[1]], welded[t[2]]});
    }
    std::unordered_set<std::uint32_t> pinched;
    for (const mesh::Edge& edge : mesh::edges(around_welded))
      if (edge.is_nonmanifold())
        for (const auto end : {edge.a, edge.b})
          if (is_shared[end]) pinched.insert(end);
    bool has_moved = false;
    for (std::uint32_t v = 0; v < weights.size() && !pinched.empty(); ++v) {
      const bool is_inner = face_count(weights[v]) == 0;
      if (is_used[v] && is_inner && is_shared[v] && pinched.contains(welded[v]) && (welded[v] != v || round > 0))
        has_moved |= step_aside(v, weights, places);
    }
    if (!has_moved) return;
  }
}

}  // namespace colossus::codec
