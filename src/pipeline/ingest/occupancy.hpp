// Where the input is crowded: how many vertices lie in which cube of the root's 2^21 at level 7.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/facts/catalog.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::ingest {

struct Occupancy {
  static constexpr int kLevel = 7;
  struct Cell {
    std::array<std::uint8_t, 3> at{};
    std::uint8_t padding = 0;
    std::uint32_t vertices = 0;
  };
  std::vector<Cell> cells;  // those with vertices

  // Cubes with vertices at any level; beyond kLevel as many as a surface has.
  double cubes_at(int level) const;
};

// Reads all vertices once more. On rank 0. Collective.
Occupancy count_occupancy(const run::Workspace& workspace, const facts::Catalog& catalog);

}  // namespace colossus::pipeline::ingest
