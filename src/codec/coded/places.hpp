// Barycentric weights as places that vertices can stand at.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "codec/coded/weights.hpp"

namespace colossus::codec::coded {

struct WeightsHash {
  std::size_t operator()(const Weights& weights) const;
};

// Which vertex stands at a place; of several, any.
using Places = std::unordered_map<Weights, std::uint32_t, WeightsHash>;

// On how many faces of the tetrahedron the place lies.
std::size_t face_count(const Weights& weights);

// Whether there is a face that both places lie on.
bool share_face(const Weights& a, const Weights& b);

// For each vertex the first one with the same weights. Linear.
std::vector<std::uint32_t> first_at_place(const std::vector<Weights>& weights);

// Moves vertex v by as few units as it takes, at most 8, to a place that none of `places` is, and notes it
// there; weights that are 0 stay 0, and no others become 0. False when there is no such place. The first one
// in the order of the corners, so that both sides of a face choose the same.
bool step_aside(std::uint32_t v, std::vector<Weights>& weights, Places& places);

// Halfway between two places, on no face that they do not share.
Weights middle_of(const Weights& a, const Weights& b);

// The nearest place that is on no face.
Weights off_faces(Weights weights);

}  // namespace colossus::codec::coded
