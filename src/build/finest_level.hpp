// Whether the surface is there: the finest level beside the input.
#pragma once

#include "build/catalog.hpp"
#include "build/hierarchy.hpp"

namespace colossus::build {

// In square units of the container's lattice.
struct AreaCheck {
  AreaCheck(const Catalog& catalog, const Hierarchy& hierarchy);
  // By more than a thousandth, at 12 bits and more: where triangles are thinner than their quantisation.
  bool differs() const;

  double input = 0.0;
  double finest = 0.0;
  int position_bits = 0;
};

// Throws Error(kBadData) when the leaves of the hierarchy, whose lattice is set, have no triangle, or less
// than half of the input's area. Not collective; as soon as the leaves are made.
void refuse_lost_surface(const Catalog& catalog, const Hierarchy& hierarchy);

// Says in the log how the finest level compares with the input, and warns where areas differ. Not collective.
void log_finest_level(const Catalog& catalog, const Hierarchy& hierarchy);

}  // namespace colossus::build
