// How far the input reaches, and whether a few far corners alone make the lattice coarse for all the rest.
#pragma once

#include "pipeline/ingest/join.hpp"

namespace colossus::pipeline::ingest {

// Sets the catalogue's bounds, those of the vertices that triangles use, and its far corner, on all ranks,
// and warns of the latter. A corner is far when the nearest 99.9 % of the vertices (by their distance from
// the middle, the median of each coordinate; all but one of 16 to 1000 vertices) have bounds ten times
// smaller. One pass over the vertices; a second one where a sample of them says that there may be such a
// corner. Throws Error(kBadData) for coordinates so large that their differences overflow. Collective.
void measure_extent(const run::Workspace& workspace, facts::Catalog& catalog,
                    const std::vector<TriangleGroup>& groups);

// Where there is a far corner: sets its median edge, of a sample of the triangles. One pass over the groups,
// whose requests have been answered. Collective.
void measure_median_edge(const run::Workspace& workspace, facts::Catalog& catalog,
                         std::span<const TriangleGroup> groups);

// " (...)" that names the far corner; empty where there is none. For messages.
std::string far_corner_text(const facts::Catalog& catalog);

// Throws Error(kBadData) that names the far corner when there is one, and because of it points up to `apart`
// (world units) from each other may fall together, which is more than the median edge is long, unless
// options.keep_outliers. Asked once for the lattice alone, and by each scheme for what it adds. Not
// collective.
void refuse_far_corner(const facts::BuildOptions& options, const facts::Catalog& catalog, double apart);

}  // namespace colossus::pipeline::ingest
