// Triangles in an order that graphics hardware likes, and that compresses well.
#pragma once

#include <cstddef>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::codec {

// Deterministic; linear. Corners keep their cyclic order.
void order_for_cache(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count);

}  // namespace colossus::codec
