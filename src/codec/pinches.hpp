// Quantisation lets vertices fall together. Where whole edges do, a reader who welds equal points would find
// a non-manifold edge that the input did not have.
#pragma once

#include <vector>

#include "codec/node_mesh.hpp"

namespace colossus::codec {

// Where the polyline in which the surface ends on a face turns back on itself within a few units of weight,
// as around the cap of a spike, its turning points join their neighbours. The only place where a vertex on a
// face depends on others: on the net border edges within that face, which are the same from both sides
// wherever the surface is closed. `weights` are those of mesh.vertices. Nearly linear in the number of
// triangles at faces.
void flatten_turns(const mesh::Mesh& mesh, std::vector<Weights>& weights);

// Moves vertices on no face by one unit of weight where edges fall together. `triangles` are those that are
// left after merging. Vertices on faces stay, or neighbours would disagree. Linear.
void separate_edges(const std::vector<mesh::Triangle>& triangles, std::vector<Weights>& weights);

// Gives edges that still fall together, since their ends lie on faces, a vertex of their own in the middle.
// Edges within a face stay: where a sheet thinner than a unit of weight ends there, a non-manifold edge
// remains.
void split_edges(std::vector<mesh::Vertex>& vertices, std::vector<mesh::Triangle>& triangles,
                 std::vector<Weights>& weights);

}  // namespace colossus::codec
