// Quantisation lets vertices fall together. Where whole edges do, a reader who welds equal points would find a
// non-manifold edge that the input did not have; here some vertices step aside by one unit of weight.
#pragma once

#include <vector>

#include "codec/node_mesh.hpp"

namespace colossus::codec {

// First the edges of the polylines in which the mesh ends on each face of its tetrahedron. `weights` are those of
// mesh.vertices. What is done to a face depends on its polyline alone, so the tetrahedra on both sides, at all levels,
// do the same; vertices on two faces stay. Nearly linear in the number of triangles at faces.
void separate_polylines(const mesh::Mesh& mesh, std::vector<Weights>& weights);

// Then all others: only vertices on no face move. `triangles` are those that are left after merging. Linear.
void separate_edges(const std::vector<mesh::Triangle>& triangles, std::vector<Weights>& weights);

}  // namespace colossus::codec
