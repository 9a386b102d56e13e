// Where a region will be parted when it is simplified for the next level.
#pragma once

#include <cstdint>
#include <vector>

#include "simplify/region.hpp"
#include "simplify/survivors.hpp"

namespace colossus::simplify {

// The vertices whose triangles will be in different regions then: all of these will be locked.
class NextBorders {
 public:
  // Of the region's live triangles. Linear; nothing where the next regions are not known.
  void find(const Region& region) {
    if (region.next_regions.empty()) return;
    next_region_.assign(region.mesh.vertices.size(), kNone);
    for (std::size_t i = 0; i < region.mesh.triangles.size(); ++i) {
      if (is_dead(region.mesh.triangles[i])) continue;
      const std::uint32_t next = region.next_regions[region.cells[i]];
      for (const auto v : region.mesh.triangles[i])
        next_region_[v] = next_region_[v] == kNone || next_region_[v] == next ? next : kSeveral;
    }
  }

  // As of the last find().
  bool has(std::uint32_t vertex) const { return !next_region_.empty() && next_region_[vertex] == kSeveral; }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint32_t kSeveral = kNone - 1;
  std::vector<std::uint32_t> next_region_;  // per vertex
};

}  // namespace colossus::simplify
