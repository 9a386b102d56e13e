// The axes in which a tetrahedron's weights are predicted.
#pragma once

#include "codec/coded/coded_node.hpp"
#include "hierarchy/diamond.hpp"

namespace colossus::codec::coded {

// Where the first three weights lead: the corners as seen from the last, in units that make them small.
Frame frame_of(const hierarchy::Tetrahedron& tetrahedron);

}  // namespace colossus::codec::coded
