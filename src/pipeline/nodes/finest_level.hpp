// Whether the surface is there: the finest level beside the input.
#pragma once

#include "pipeline/facts/catalog.hpp"
#include "pipeline/facts/finished_nodes.hpp"

namespace colossus::pipeline::nodes {

// In square units of the container's lattice.
struct AreaCheck {
  AreaCheck(const facts::Catalog& catalog, const facts::FinishedNodes& finished);
  // By more than a thousandth, at 12 bits and more: where triangles are thinner than their quantisation.
  bool differs() const;

  double input = 0.0;
  double finest = 0.0;
  int position_bits = 0;
};

// Throws Error(kBadData) when the leaves of the finished, whose lattice is set, have no triangle, or less
// than half of the input's area. Not collective; as soon as the leaves are made.
void refuse_lost_surface(const facts::Catalog& catalog, const facts::FinishedNodes& finished);

// Completes the counts with those of the finest level that follow from finished nodes. Not collective.
void count_finest_level(facts::Catalog& catalog, const facts::FinishedNodes& finished);

// Says in the log how the finest level compares with the input, and warns where areas differ. Not collective.
void log_finest_level(const facts::Catalog& catalog, const facts::FinishedNodes& finished);

}  // namespace colossus::pipeline::nodes
