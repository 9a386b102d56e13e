// The collapses that a pass may make, in order of their cost.
#pragma once

#include <cstdint>
#include <vector>

namespace colossus::simplify {

struct Candidate {
  float cost;  // not negative
  std::uint32_t from;
  std::uint32_t to;
};

// Drops the candidates that cost more than `factor` times the one at `rank`, counted from the cheapest; the
// others keep their order. Linear.
void drop_costly(std::vector<Candidate>& candidates, std::size_t rank, float factor);

// Stable, so that equal costs stay in order. Linear. `scratch` keeps its memory from call to call.
void sort_by_cost(std::vector<Candidate>& candidates, std::vector<Candidate>& scratch);

}  // namespace colossus::simplify
