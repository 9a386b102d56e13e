// Points of the input by the nodes of a container: for distances from the input to a node.
#pragma once

#include <cstdint>
#include <vector>

#include "reader/distance.hpp"
#include "reader/statue.hpp"

namespace colossus::reader {

struct InputSamples {
  std::vector<WorldPoint> points;
  std::vector<std::vector<std::uint32_t>> by_row;  // the points that lie in the row's tetrahedra
};

// The vertices of `surface` (of very large ones every k-th) and as many points spread over its area. Some 4
// bytes per sample and level. Deterministic for a seed.
InputSamples sample_input(const Statue& statue, const Surface& surface, std::uint64_t seed);

}  // namespace colossus::reader
