// The diamonds scheme: triangles cut into tetrahedra, simplified diamond by diamond (paper 004).
#pragma once

#include "build/scheme.hpp"

namespace colossus::build {

void check_diamonds(const BuildOptions& options);
Hierarchy build_diamonds(const Workspace& workspace, Catalog& catalog, std::vector<TriangleGroup>&& groups);

}  // namespace colossus::build
