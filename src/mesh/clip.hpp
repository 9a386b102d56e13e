// Cutting a mesh by a plane of the hierarchy, exactly.
#pragma once

#include <array>

#include "geometry/plane.hpp"
#include "mesh/mesh.hpp"

namespace colossus::mesh {

// The halves are not welded, and may hold degenerate triangles. [0] holds what lies on the positive side, [1]
// the rest. A triangle that crosses the plane becomes one triangle on one side and, for its quadrilateral
// part, two on the other (the shorter diagonal, the first if equal); pieces all of whose corners fell
// together are dropped, those that are segments stay: who welds them finds out whether anything else is
// there; a triangle that lies in the plane goes to the positive side. The order of the triangles is kept,
// pieces stay where their triangle was. Both sides get the same cut vertices. Sides and cut points are exact
// (geometry/plane.hpp); attributes are interpolated from the ends in global order, so that they too are the
// same for everybody. Linear.
std::array<Mesh, 2> split(const Mesh& mesh, const geometry::Plane& plane);

}  // namespace colossus::mesh
