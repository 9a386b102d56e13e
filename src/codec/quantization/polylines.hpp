// Where the surface ends on the faces of a tetrahedron, quantisation must not only be the same from both
// sides, but also leave the polyline one that a manifold surface can end in.
#pragma once

#include <vector>

#include "codec/coded/weights.hpp"

namespace colossus::codec::quantization {

// Mends the polylines in which the surface ends on the faces. Where one turns back on itself within a few
// units of weight, as around the cap of a spike, its turning points join their neighbours; where two of its
// edges fall together, as those of a thin sheet do, a vertex on no edge of the face steps aside a little,
// or one of the edges is split where none can. The only place where a vertex on a face depends on others: on
// the net border edges within that face, which are the same from both sides wherever the surface is closed.
// `weights` are those of mesh.vertices, and grow with them. Nearly linear in the number of triangles at
// faces.
void settle_polylines(mesh::Mesh& mesh, std::vector<coded::Weights>& weights);

}  // namespace colossus::codec::quantization
