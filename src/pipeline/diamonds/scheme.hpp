// The diamonds scheme: triangles cut into tetrahedra, simplified diamond by diamond (paper 004).
#pragma once

#include "pipeline/nodes/scheme.hpp"

namespace colossus::pipeline::diamonds {

void check_diamonds(const facts::BuildOptions& options);
facts::Hierarchy build_diamonds(const run::Workspace& workspace, facts::Catalog& catalog,
                                std::vector<ingest::TriangleGroup>&& groups);

}  // namespace colossus::pipeline::diamonds
